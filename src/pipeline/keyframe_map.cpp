#include "keyframe_map.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace deja_view {
namespace {

constexpr std::int64_t kSameStampNs = 500;

}  // namespace

KeyframeMap::KeyframeMap(std::vector<StoredKeyframe> keyframes, PoseGraph graph)
    : graph_(std::move(graph)) {
  DEJA_VIEW_CHECK_OP(static_cast<int>(keyframes.size()), ==, graph_.size());
  for (int i = 0; i < size(); ++i) {
    StoredKeyframe& keyframe = keyframes[static_cast<std::size_t>(i)];
    if (i == 0 || node(i).sequence != node(i - 1).sequence) {
      first_.push_back(i);
    }
    Append(keyframe);
    if (keyframe.is_place) {
      AddFeatures(i, std::move(keyframe.features));
    }
  }
}

void KeyframeMap::Append(const StoredKeyframe& keyframe) {
  const Rigid3& T_B_C = keyframe.features.T_B_C;
  if (extrinsics_.empty() || extrinsics_.back().t != T_B_C.t ||
      extrinsics_.back().q.coeffs() != T_B_C.q.coeffs()) {
    extrinsics_.push_back(T_B_C);
  }
  Keyframe appended;
  appended.stamp_ns = keyframe.stamp_ns;
  appended.extrinsic = static_cast<int>(extrinsics_.size()) - 1;
  keyframes_.push_back(appended);
}

int KeyframeMap::Add(const StoredKeyframe& keyframe, int sequence, const Rigid3& T_W_B) {
  DEJA_VIEW_CHECK(!keyframe.is_place);
  if (sequence == sequence_count()) {
    first_.push_back(size());
  }
  const int index = graph_.AddNode(sequence, T_W_B);
  Append(keyframe);
  return index;
}

void KeyframeMap::AddFeatures(int i, KeyframeFeatures features) {
  Keyframe& keyframe = keyframes_[static_cast<std::size_t>(i)];
  keyframe.is_place = true;
  keyframe.place = static_cast<int>(features_.size());
  features_.push_back(std::move(features));
  places_.push_back(i);
}

void KeyframeMap::MakePlace(KeyframeFeatures features) {
  DEJA_VIEW_CHECK(!keyframes_.back().is_place);
  AddFeatures(newest(), std::move(features));
  graph_.Keep(newest());
}

KeyframeFeatures& KeyframeMap::features(int i) {
  DEJA_VIEW_CHECK((*this)[i].is_place);
  return features_[static_cast<std::size_t>((*this)[i].place)];
}

const KeyframeFeatures& KeyframeMap::features(int i) const {
  DEJA_VIEW_CHECK((*this)[i].is_place);
  return features_[static_cast<std::size_t>((*this)[i].place)];
}

bool KeyframeMap::IsSameStamp(std::int64_t a_ns, std::int64_t b_ns) {
  return std::abs(a_ns - b_ns) <= kSameStampNs;
}

std::optional<int> KeyframeMap::At(std::int64_t stamp_ns) const {
  std::optional<int> found;
  std::int64_t nearest = kSameStampNs + 1;
  auto end = keyframes_.end();
  for (auto first = first_.rbegin(); first != first_.rend(); ++first) {
    const auto begin = keyframes_.begin() + *first;
    auto it = std::lower_bound(
        begin, end, stamp_ns - kSameStampNs, [](const Keyframe& keyframe, std::int64_t wanted) {
          return keyframe.stamp_ns < wanted;
        });
    for (; it != end && it->stamp_ns <= stamp_ns + kSameStampNs; ++it) {
      const std::int64_t distance = std::abs(it->stamp_ns - stamp_ns);
      if (distance < nearest) {
        nearest = distance;
        found = static_cast<int>(it - keyframes_.begin());
      }
    }
    end = begin;
  }
  return found;
}

}  // namespace deja_view
