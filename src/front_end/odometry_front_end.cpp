#include "deja_view/front_end/odometry_front_end.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/host/restart_detector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace deja_view {
namespace {

// Stamps that odometries compute as double seconds are rounded by up to this.
constexpr std::int64_t kStampToleranceNs = 200;

// Between the two images of a pair.
constexpr std::int64_t kPairToleranceNs = 1'000'000;

// Poses that go back by less are out of order; images of the time before are waited for no more.
constexpr std::int64_t kPoseMemoryNs = 10'000'000'000;

// Fewer common corners say nothing of the motion: it was large.
constexpr std::size_t kFewCorners = 20;

std::int64_t ToNanoseconds(double seconds) {
  return static_cast<std::int64_t>(std::llround(seconds * 1e9));
}

/// Calls f(index in a, index in b) for each corner that both have; ids ascend in both.
template <typename F>
void ForEachCommon(const TrackedCorners& a, const TrackedCorners& b, F f) {
  std::size_t i = 0;
  std::size_t k = 0;
  while (i < a.ids.size() && k < b.ids.size()) {
    if (a.ids[i] == b.ids[k]) {
      f(i, k);
    }
    const bool a_is_first = a.ids[i] < b.ids[k];
    const bool b_is_first = b.ids[k] < a.ids[i];
    i += b_is_first ? 0 : 1;
    k += a_is_first ? 0 : 1;
  }
}

const FrontEndSetup& Checked(const FrontEndSetup& setup) {
  if (const auto violations = setup.options.Validate(); !violations.empty()) {
    ThrowInputError("front_end: {}", fmt::join(violations, "; "));
  }
  return setup;
}

}  // namespace

std::vector<std::string> OdometryFrontEndOptions::Validate() const {
  Requirements r;
  const auto is_duration = [](double seconds) { return seconds > 0 && seconds <= 3600; };
  r.That(min_motion_px >= 0, "min_motion_px", min_motion_px, "at least 0 px");
  r.That(min_interval_s >= 0, "min_interval_s", min_interval_s, "at least 0 s");
  r.That(is_duration(window_s), "window_s", window_s, "0 to 3600 s");
  r.That(delay_s >= 0 && delay_s <= 3600, "delay_s", delay_s, "0 to 3600 s");
  r.That(is_duration(max_pose_gap_s), "max_pose_gap_s", max_pose_gap_s, "0 to 3600 s");
  r.That(is_duration(sequence_gap_s), "sequence_gap_s", sequence_gap_s, "0 to 3600 s");
  r.That(image_memory_mb > 0, "image_memory_mb", image_memory_mb, "more than 0 MB");
  r.Group("tracker", tracker.Validate());
  r.Group("points", points.Validate());
  return r.errors();
}

OdometryFrontEnd::OdometryFrontEnd(const FrontEndSetup& setup,
                                   KeyframeCallback on_keyframe,
                                   ProblemCallback on_problem)
    : options_(Checked(setup).options),
      camera_(setup.camera),
      T_B_C_(setup.T_B_C),
      second_(setup.second),
      on_keyframe_(std::move(on_keyframe)),
      on_problem_(std::move(on_problem)),
      gravity_(setup.gravity),
      level_(setup.gravity),
      tracker_(setup.options.tracker) {
  DEJA_VIEW_CHECK(camera_ != nullptr && on_keyframe_);
}

void OdometryFrontEnd::AddImage(std::int64_t stamp_ns, ImageSource image, std::size_t bytes) {
  ++counts_.images;
  Wait({stamp_ns, std::move(image), bytes}, &waiting_);
}

void OdometryFrontEnd::AddSecondImage(std::int64_t stamp_ns, ImageSource image, std::size_t bytes) {
  DEJA_VIEW_CHECK(second_.has_value());
  Wait({stamp_ns, std::move(image), bytes}, &waiting_second_);
}

// By stamp, so that a stray one that lies in the future holds up nothing.
void OdometryFrontEnd::Wait(WaitingImage image, ImageQueue* queue) {
  queue->Add(std::move(image));
  while (static_cast<double>(queue->bytes()) > 1e6 * options_.image_memory_mb) {
    ++counts_.overflows;
    Tell(fmt::format("image of stamp {} ns: no {} came while {:.0f} MB of images waited",
                     queue->Pop().stamp_ns,
                     second_ ? "odometry or image of the other camera" : "odometry",
                     options_.image_memory_mb));
  }
  FollowWaiting();
}

void OdometryFrontEnd::AddPose(std::int64_t stamp_ns, const Rigid3& T_W_B) {
  ++counts_.poses;
  const StampedPose pose{stamp_ns, T_W_B};
  if (!poses_.empty() && stamp_ns <= poses_.back().stamp_ns) {
    ++counts_.stray_stamps;
    if (suspect_ && stamp_ns > suspect_->stamp_ns) {
      Restart(*suspect_);
      poses_.push_back(pose);
    } else {
      suspect_ = pose;
    }
  } else {
    suspect_.reset();
    poses_.push_back(pose);
  }
  while (poses_.back().stamp_ns - poses_.front().stamp_ns > kPoseMemoryNs) {
    poses_.pop_front();
  }
  FollowWaiting();
}

void OdometryFrontEnd::Restart(const StampedPose& first) {
  Tell(fmt::format("the odometry's stamps go back to {} ns: it started anew", first.stamp_ns));
  HandOver(true);
  GiveUpUnlevelled();
  level_ = WorldLevel(gravity_);
  const std::int64_t newest_ns = poses_.back().stamp_ns;
  waiting_.DropFrom(newest_ns);
  waiting_second_.DropFrom(newest_ns);
  poses_ = {first};
  suspect_.reset();
  frames_.clear();
  last_keyframe_.reset();
  tracker_.Restart();
}

// Whether all is there that may belong to an image.
bool OdometryFrontEnd::IsComplete(std::int64_t stamp_ns) const {
  const bool has_pair =
      !second_ || is_ended_ ||
      (!waiting_second_.empty() && waiting_second_.back().stamp_ns >= stamp_ns - kPairToleranceNs);
  return has_pair && !poses_.empty() && stamp_ns <= poses_.back().stamp_ns + kStampToleranceNs;
}

void OdometryFrontEnd::FollowWaiting() {
  while (!waiting_.empty() && IsComplete(waiting_.front().stamp_ns)) {
    const WaitingImage waiting = waiting_.Pop();
    waiting_second_.DropBefore(waiting.stamp_ns - kPairToleranceNs);
    if (!frames_.empty() && waiting.stamp_ns <= frames_.back().stamp_ns) {
      ++counts_.stray_stamps;
      Tell(fmt::format("image of stamp {} ns: older than the one before", waiting.stamp_ns));
      continue;
    }
    if (const auto T_W_B = PoseAt(waiting.stamp_ns)) {
      Follow(waiting, *T_W_B);
    } else {
      ++counts_.without_pose;
    }
  }
}

std::optional<Rigid3> OdometryFrontEnd::PoseAt(std::int64_t stamp_ns) const {
  const auto after =
      std::lower_bound(poses_.begin(),
                       poses_.end(),
                       stamp_ns - kStampToleranceNs,
                       [](const StampedPose& p, auto stamp) { return p.stamp_ns < stamp; });
  if (after == poses_.end()) {
    return std::nullopt;
  }
  if (after->stamp_ns <= stamp_ns + kStampToleranceNs) {
    return after->pose;
  }
  if (after == poses_.begin()) {
    return std::nullopt;
  }
  const StampedPose& before = *std::prev(after);
  const std::int64_t gap_ns = after->stamp_ns - before.stamp_ns;
  if (gap_ns > ToNanoseconds(options_.max_pose_gap_s)) {
    return std::nullopt;
  }
  return Interpolate(before.pose,
                     after->pose,
                     static_cast<double>(stamp_ns - before.stamp_ns) / static_cast<double>(gap_ns));
}

std::optional<cv::Mat> OdometryFrontEnd::Decode(const WaitingImage& waiting, const Camera& camera) {
  try {
    cv::Mat image = waiting.source();
    if (image.cols != camera.width() || image.rows != camera.height()) {
      ThrowInputError("image of stamp {} ns: {} x {} px: expected the camera's {} x {}",
                      waiting.stamp_ns,
                      image.cols,
                      image.rows,
                      camera.width(),
                      camera.height());
    }
    return image;
  } catch (const InputError& error) {
    ++counts_.bad_images;
    Tell(error.what());
    return std::nullopt;
  }
}

void OdometryFrontEnd::Follow(const WaitingImage& waiting, const Rigid3& T_W_B) {
  const auto image = Decode(waiting, *camera_);
  if (!image) {
    return;
  }
  const std::size_t n = frames_.size();
  const bool is_paused =
      n >= 1 && waiting.stamp_ns - frames_.back().stamp_ns > ToNanoseconds(options_.sequence_gap_s);
  // Tracks that went on would mix two worlds.
  const bool is_jump =
      n >= 2 && IsJump(frames_[n - 2].pose(), frames_[n - 1].pose(), {waiting.stamp_ns, T_W_B});
  if (is_paused || is_jump) {
    HandOver(true);
    frames_.clear();
    last_keyframe_.reset();
    tracker_.Restart();
  }
  Frame frame;
  frame.stamp_ns = waiting.stamp_ns;
  frame.T_W_B = T_W_B;
  frame.corners = tracker_.Add(*image);
  const Rigid3 T_W_C = T_W_B * T_B_C_;
  level_.Add(T_W_C);
  for (const cv::Point2f& pixel : frame.corners.pixels) {
    frame.rays_W.push_back(T_W_C.q * camera_->Unproject({pixel.x, pixel.y}));
  }
  frame.is_keyframe = IsKeyframe(frame);
  if (frame.is_keyframe) {
    frame.second_rays = FindSecondRays(frame);
    last_keyframe_ = frame;
  }
  frames_.push_back(std::move(frame));
  HandOver(false);
  Prune();
}

std::vector<OdometryFrontEnd::SecondRay> OdometryFrontEnd::FindSecondRays(const Frame& frame) {
  std::vector<SecondRay> rays;
  if (waiting_second_.empty() ||
      waiting_second_.front().stamp_ns > frame.stamp_ns + kPairToleranceNs) {
    return rays;
  }
  const auto image = Decode(waiting_second_.Pop(), *second_->camera);
  if (!image) {
    return rays;
  }
  const Eigen::Quaterniond q_W_C = frame.T_W_B.q * second_->T_B_C.q;
  const auto pixels = tracker_.FindIn(*image);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (pixels[i]) {
      rays.push_back({i, q_W_C * second_->camera->Unproject({pixels[i]->x, pixels[i]->y})});
    }
  }
  return rays;
}

bool OdometryFrontEnd::IsKeyframe(const Frame& frame) const {
  if (!last_keyframe_) {
    return true;
  }
  if (frame.stamp_ns - last_keyframe_->stamp_ns < ToNanoseconds(options_.min_interval_s)) {
    return false;
  }
  std::vector<double> moved;
  ForEachCommon(frame.corners, last_keyframe_->corners, [&](std::size_t i, std::size_t k) {
    moved.push_back(cv::norm(frame.corners.pixels[i] - last_keyframe_->corners.pixels[k]));
  });
  if (moved.size() < kFewCorners) {
    return true;
  }
  const auto middle = moved.begin() + static_cast<std::ptrdiff_t>(moved.size() / 2);
  std::nth_element(moved.begin(), middle, moved.end());
  return *middle >= options_.min_motion_px;
}

void OdometryFrontEnd::HandOver(bool is_end) {
  for (Frame& frame : frames_) {
    const std::int64_t age_ns = frames_.back().stamp_ns - frame.stamp_ns;
    if (!frame.is_keyframe || frame.is_handed_over ||
        (!is_end && age_ns < ToNanoseconds(options_.delay_s))) {
      continue;
    }
    frame.is_handed_over = true;
    unlevelled_.push_back(MakeKeyframe(frame));
  }
  HandOverLevel();
}

void OdometryFrontEnd::HandOverLevel() {
  const auto T_L_W = level_.T_L_W();
  if (!T_L_W) {
    return;
  }
  for (Keyframe& keyframe : unlevelled_) {
    keyframe.T_W_B = *T_L_W * keyframe.T_W_B;
    for (TrackedPoint& point : keyframe.points) {
      point.p_W = *T_L_W * point.p_W;
    }
    ++counts_.keyframes;
    counts_.without_points += keyframe.points.empty() ? 1 : 0;
    counts_.points += static_cast<std::int64_t>(keyframe.points.size());
    on_keyframe_(std::move(keyframe));
  }
  unlevelled_.clear();
}

OdometryFrontEnd::Keyframe OdometryFrontEnd::MakeKeyframe(const Frame& frame) const {
  // The keyframe's own ray comes first.
  std::vector<std::vector<TrackRay>> tracks(frame.corners.ids.size());
  const Eigen::Vector3d centre_W = frame.T_W_B * T_B_C_.t;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    tracks[i].push_back({centre_W, frame.rays_W[i]});
  }
  for (const Frame& other : frames_) {
    const std::int64_t later_ns = other.stamp_ns - frame.stamp_ns;
    if (&other == &frame || later_ns < -ToNanoseconds(options_.window_s) ||
        later_ns > ToNanoseconds(options_.delay_s)) {
      continue;
    }
    const Eigen::Vector3d other_centre_W = other.T_W_B * T_B_C_.t;
    ForEachCommon(frame.corners, other.corners, [&](std::size_t i, std::size_t k) {
      tracks[i].push_back({other_centre_W, other.rays_W[k]});
    });
  }
  for (const SecondRay& second : frame.second_rays) {
    tracks[second.corner].push_back({frame.T_W_B * second_->T_B_C.t, second.ray_W});
  }
  Keyframe keyframe{frame.stamp_ns, frame.T_W_B, {}};
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (const auto point = TriangulateTrack(tracks[i], camera_->FocalLength(), options_.points)) {
      const cv::Point2f& pixel = frame.corners.pixels[i];
      keyframe.points.push_back({point->p_W, {pixel.x, pixel.y}, frame.corners.ids[i]});
    }
  }
  return keyframe;
}

// Frames that no keyframe will look at any more.
void OdometryFrontEnd::Prune() {
  std::int64_t oldest_ns = frames_.back().stamp_ns;
  for (const Frame& frame : frames_) {
    if (frame.is_keyframe && !frame.is_handed_over) {
      oldest_ns = frame.stamp_ns;
      break;
    }
  }
  while (oldest_ns - frames_.front().stamp_ns > ToNanoseconds(options_.window_s)) {
    frames_.pop_front();
  }
}

void OdometryFrontEnd::Flush() {
  is_ended_ = true;
  FollowWaiting();
  HandOver(true);
  GiveUpUnlevelled();
  counts_.without_pose += static_cast<std::int64_t>(waiting_.size());
  waiting_ = {};
  waiting_second_ = {};
  is_ended_ = false;
}

void OdometryFrontEnd::GiveUpUnlevelled() {
  if (!unlevelled_.empty()) {
    Tell(fmt::format("{} keyframes: the camera turned too little to tell which way is up",
                     unlevelled_.size()));
    unlevelled_.clear();
  }
}

void OdometryFrontEnd::Tell(const std::string& what) const {
  if (on_problem_) {
    on_problem_(what);
  }
}

}  // namespace deja_view
