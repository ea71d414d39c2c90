#include "deja_view/host/keyframe_assembler.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace deja_view {
namespace {

constexpr std::int64_t kNanoseconds = 1000000000;

// Stamps further apart than this do not belong to the same stretch of a flight: a stray stamp, or a
// restart.
constexpr std::int64_t kStretchNs = 10 * kNanoseconds;

// Poses remembered to know a duplicate.
constexpr std::size_t kPoseMemory = 8;

// What counts the drops, in the order of their reasons.
constexpr std::array<std::int64_t AssemblerCounts::*, kEnumNames<DropReason>.size()> kDropCounts = {
    &AssemblerCounts::missing_image,
    &AssemblerCounts::missing_points,
    &AssemblerCounts::duplicates,
    &AssemblerCounts::stray_stamps,
    &AssemblerCounts::overflows,
    &AssemblerCounts::unmatched,
    &AssemblerCounts::extrinsic_jumps};

std::int64_t ToNanoseconds(double seconds) {
  return static_cast<std::int64_t>(std::llround(seconds * 1e9));
}

bool FollowsWithinStretch(std::int64_t later, std::int64_t earlier) {
  return later > earlier && later - earlier <= kStretchNs;
}

}  // namespace

KeyframeInput AssembledKeyframe::ToInput() const {
  KeyframeInput input;
  input.stamp_ns = stamp_ns;
  input.T_W_B = T_W_B;
  input.image = image();
  input.points = points;
  input.starts_sequence = starts_sequence;
  return input;
}

KeyframeAssembler::KeyframeAssembler(const KeyframeAssemblerOptions& options,
                                     KeyframeCallback on_keyframe,
                                     DropCallback on_drop)
    : options_(options),
      on_keyframe_(std::move(on_keyframe)),
      on_drop_(std::move(on_drop)),
      restart_detector_(options.sequence_gap_s) {
  if (const auto violations = options_.Validate(); !violations.empty()) {
    ThrowInputError("{}", fmt::join(violations, "; "));
  }
  DEJA_VIEW_CHECK(on_keyframe_);
}

std::int64_t KeyframeAssembler::Key(std::int64_t stamp_ns) {
  std::int64_t whole = stamp_ns / kNanoseconds;
  std::int64_t rest = stamp_ns % kNanoseconds;
  const double seconds = static_cast<double>(whole) + 1e-9 * static_cast<double>(rest);
  whole = static_cast<std::int64_t>(std::floor(seconds));
  rest = std::llround((seconds - static_cast<double>(whole)) * 1e9);
  return whole * kNanoseconds + rest;
}

void KeyframeAssembler::AddImage(std::int64_t stamp_ns, ImageSource image, std::size_t bytes) {
  DEJA_VIEW_CHECK(image);
  ++counts_.images;
  const std::int64_t key = Key(stamp_ns);
  NoteImageStamp(key);
  const bool is_held =
      std::any_of(images_.begin(), images_.end(), [key](const auto& i) { return i.key == key; });
  Pending* owner = FindPending(key);
  if (is_held || (owner != nullptr && owner->image)) {
    Drop(DropReason::kDuplicate, stamp_ns);
    return;
  }
  if (owner != nullptr) {
    owner->image = std::move(image);
    owner->image_bytes = bytes;
  } else if (!IsHopeless(key)) {
    HoldImage({key, std::move(image), bytes});
  }
  for (Pending& pending : pending_) {
    pending.later_images += FollowsWithinStretch(key, pending.key) ? 1 : 0;
  }
  Settle();
}

void KeyframeAssembler::AddPoints(std::int64_t stamp_ns, std::vector<TrackedPoint> points) {
  ++counts_.points;
  const std::int64_t key = Key(stamp_ns);
  const bool is_held =
      std::any_of(points_.begin(), points_.end(), [key](const auto& p) { return p.key == key; });
  Pending* owner = FindPending(key);
  if (is_held || (owner != nullptr && owner->points)) {
    Drop(DropReason::kDuplicate, stamp_ns);
    return;
  }
  if (owner != nullptr) {
    owner->points = std::move(points);
  } else if (IsHopeless(key)) {
    Drop(DropReason::kUnmatched, stamp_ns);
  } else {
    points_.push_back({key, std::move(points)});
  }
  for (Pending& pending : pending_) {
    pending.later_points += FollowsWithinStretch(key, pending.key) ? 1 : 0;
  }
  while (points_.size() > static_cast<std::size_t>(options_.max_pending)) {
    Drop(DropReason::kOverflow, points_.front().key);
    points_.pop_front();
  }
  Settle();
}

void KeyframeAssembler::AddExtrinsic(std::int64_t stamp_ns, const Rigid3& T_B_C) {
  const std::int64_t key = Key(stamp_ns);
  if (!extrinsics_.Add(key, T_B_C)) {
    Drop(DropReason::kExtrinsicJump, stamp_ns);
  }
  awaits_extrinsic_ = awaits_extrinsic_ || (!pose_keys_.empty() && pose_keys_.back() == key);
  Settle();
}

void KeyframeAssembler::AddPose(std::int64_t stamp_ns, const Rigid3& T_W_B) {
  ++counts_.poses;
  Pending pending;
  pending.key = Key(stamp_ns);
  pending.stamp_ns = stamp_ns;
  pending.T_W_B = T_W_B;
  if (IsKnown(pending.key)) {
    Drop(DropReason::kDuplicate, stamp_ns);
    return;
  }
  const bool goes_back = !pose_keys_.empty() && pending.key < pose_keys_.back();
  const bool confirms = goes_back && suspect_ && FollowsWithinStretch(pending.key, suspect_->key);
  if (suspect_ && !confirms) {
    Drop(DropReason::kStrayStamp, suspect_->stamp_ns);
    suspect_.reset();
  }
  if (goes_back && !confirms) {
    suspect_ = std::move(pending);
    return;
  }
  if (confirms) {
    if (IsNewestPoseStray()) {
      DropNewestPose();
    } else {
      ResolveAll();
      pose_keys_.clear();
      suspect_->is_restart = true;
    }
    Push(std::move(*suspect_));
    suspect_.reset();
  }
  Push(std::move(pending));
  Settle();
}

// The suspect goes on where the pose before the newest one left off.
bool KeyframeAssembler::IsNewestPoseStray() const {
  return pose_keys_.size() >= 2 &&
         FollowsWithinStretch(suspect_->key, pose_keys_[pose_keys_.size() - 2]);
}

void KeyframeAssembler::DropNewestPose() {
  const std::int64_t key = pose_keys_.back();
  pose_keys_.pop_back();
  if (!pending_.empty() && pending_.back().key == key) {
    Drop(DropReason::kStrayStamp, pending_.back().stamp_ns);
    pending_.pop_back();
  }
}

void KeyframeAssembler::Flush() {
  ResolveAll();
  if (suspect_) {
    Drop(DropReason::kStrayStamp, suspect_->stamp_ns);
    suspect_.reset();
  }
  for (const auto& points : points_) {
    Drop(DropReason::kUnmatched, points.key);
  }
  points_.clear();
  images_.clear();
  image_bytes_ = 0;
}

void KeyframeAssembler::Drop(DropReason reason, std::int64_t stamp_ns) {
  const std::int64_t count = ++(counts_.*kDropCounts[static_cast<std::size_t>(reason)]);
  if (reason == DropReason::kExtrinsicJump && count > 1) {
    return;  // told once
  }
  if (on_drop_) {
    on_drop_(reason, stamp_ns);
  }
}

bool KeyframeAssembler::IsKnown(std::int64_t key) const {
  return (suspect_ && suspect_->key == key) ||
         std::find(pose_keys_.begin(), pose_keys_.end(), key) != pose_keys_.end() ||
         std::any_of(
             pending_.begin(), pending_.end(), [key](const Pending& p) { return p.key == key; });
}

// Poses come in order, so that nobody will ask for a stamp older than the last pose but one (the
// last one may be stray). Much older stamps are the first messages of a restart.
bool KeyframeAssembler::IsHopeless(std::int64_t key) const {
  if (pose_keys_.size() < 2 || (suspect_ && suspect_->key == key)) {
    return false;
  }
  return FollowsWithinStretch(pose_keys_[pose_keys_.size() - 2], key);
}

KeyframeAssembler::Pending* KeyframeAssembler::FindPending(std::int64_t key) {
  for (Pending& pending : pending_) {
    if (pending.key == key) {
      return &pending;
    }
  }
  return nullptr;
}

// A pause counts against the newer of the last two images, and is forgotten when the stamps go back
// below it: a stray stamp makes no pause.
void KeyframeAssembler::NoteImageStamp(std::int64_t key) {
  pauses_.erase(
      std::remove_if(
          pauses_.begin(), pauses_.end(), [key](std::int64_t pause) { return pause > key; }),
      pauses_.end());
  if (!image_keys_.empty()) {
    const std::int64_t before = *std::max_element(image_keys_.begin(), image_keys_.end());
    if (key - before > ToNanoseconds(options_.sequence_gap_s)) {
      pauses_.push_back(key);
    }
  }
  image_keys_.push_back(key);
  if (image_keys_.size() > 2) {
    image_keys_.pop_front();
  }
}

void KeyframeAssembler::Push(Pending pending) {
  const auto has_key = [&pending](const auto& held) { return held.key == pending.key; };
  if (const auto image = std::find_if(images_.begin(), images_.end(), has_key);
      image != images_.end()) {
    pending.image = std::move(image->value);
    pending.image_bytes = image->bytes;
    image_bytes_ -= image->bytes;
    images_.erase(image);
  }
  if (const auto points = std::find_if(points_.begin(), points_.end(), has_key);
      points != points_.end()) {
    pending.points = std::move(points->value);
    points_.erase(points);
  }
  const std::int64_t timeout = ToNanoseconds(options_.timeout_s);
  for (Pending& earlier : pending_) {
    earlier.later_poses += pending.key > earlier.key + timeout ? 1 : 0;
  }
  pose_keys_.push_back(pending.key);
  if (pose_keys_.size() > kPoseMemory) {
    pose_keys_.pop_front();
  }
  pending_.push_back(std::move(pending));
  PruneImages();
  PrunePoints();
}

void KeyframeAssembler::Settle() {
  while (!pending_.empty()) {
    const Pending& head = pending_.front();
    const bool is_late = head.later_poses >= options_.later_messages;
    const bool image_is_settled =
        head.image || is_late || head.later_images >= options_.later_messages;
    const bool points_are_settled =
        head.points || is_late || head.later_points >= options_.later_messages;
    // Without an image there is nothing to wait for: points alone make no keyframe.
    const bool is_settled =
        image_is_settled && (points_are_settled || !head.image) && CalibrationIsSettled();
    const bool overflows = pending_.size() > static_cast<std::size_t>(options_.max_pending) ||
                           static_cast<double>(PendingBytes()) > 1e6 * options_.image_memory_mb;
    if (!is_settled && !overflows) {
      return;
    }
    if (!is_settled) {
      Drop(DropReason::kOverflow, head.stamp_ns);
    }
    Pending resolved = std::move(pending_.front());
    pending_.pop_front();
    Resolve(std::move(resolved));
  }
}

// Nor is one waited for once later keyframes have come.
bool KeyframeAssembler::CalibrationIsSettled() const {
  return !awaits_extrinsic_ || extrinsics_.Reaches(pending_.front().key) ||
         pending_.size() > static_cast<std::size_t>(options_.later_messages);
}

std::size_t KeyframeAssembler::PendingBytes() const {
  std::size_t bytes = 0;
  for (const Pending& pending : pending_) {
    bytes += pending.image_bytes;
  }
  return bytes;
}

void KeyframeAssembler::Resolve(Pending pending) {
  NoteRestart(pending);
  awaits_extrinsic_ = awaits_extrinsic_ && extrinsics_.Reaches(pending.key);
  if (!pending.image) {
    Drop(DropReason::kMissingImage, pending.stamp_ns);
    return;
  }
  if (!pending.points) {
    Drop(DropReason::kMissingPoints, pending.stamp_ns);
    pending.points.emplace();
  }
  ++counts_.keyframes;
  while (!pauses_.empty() && pauses_.front() <= pending.key) {
    starts_sequence_ = true;
    pauses_.pop_front();
  }
  AssembledKeyframe keyframe;
  keyframe.starts_sequence = std::exchange(starts_sequence_, false);
  keyframe.is_restart = std::exchange(is_restart_, false);
  keyframe.stamp_ns = pending.stamp_ns;
  keyframe.T_W_B = pending.T_W_B;
  keyframe.image = std::move(pending.image);
  keyframe.image_bytes = pending.image_bytes;
  keyframe.points = std::move(*pending.points);
  keyframe.T_B_C = extrinsics_.At(pending.key - 1);  // one of this stamp may still be on its way
  on_keyframe_(std::move(keyframe));
}

void KeyframeAssembler::ResolveAll() {
  while (!pending_.empty()) {
    Pending pending = std::move(pending_.front());
    pending_.pop_front();
    Resolve(std::move(pending));
  }
}

// Also by a keyframe whose image is missing.
void KeyframeAssembler::NoteRestart(const Pending& pending) {
  if (pending.is_restart) {
    restart_detector_.Reset();
  }
  const bool is_found =
      pending.points && restart_detector_.Add(pending.stamp_ns, pending.T_W_B, *pending.points);
  if (pending.is_restart || is_found) {
    ++counts_.restarts;
    starts_sequence_ = true;
    is_restart_ = true;
  }
}

void KeyframeAssembler::HoldImage(HeldImage image) {
  image_bytes_ += image.bytes;
  images_.push_back(std::move(image));
  while (static_cast<double>(image_bytes_) > 1e6 * options_.image_memory_mb) {
    Drop(DropReason::kOverflow, images_.front().key);
    image_bytes_ -= images_.front().bytes;
    images_.pop_front();
  }
}

// What came before an image that nobody will ask for is older still, or of a run that is over.
void KeyframeAssembler::PruneImages() {
  const auto last = std::find_if(images_.rbegin(), images_.rend(), [this](const auto& image) {
    return IsHopeless(image.key);
  });
  for (auto image = images_.begin(); image != last.base(); ++image) {
    image_bytes_ -= image->bytes;
  }
  images_.erase(images_.begin(), last.base());
}

void KeyframeAssembler::PrunePoints() {
  for (auto points = points_.begin(); points != points_.end();) {
    if (IsHopeless(points->key)) {
      Drop(DropReason::kUnmatched, points->key);
      points = points_.erase(points);
    } else {
      ++points;
    }
  }
}

}  // namespace deja_view
