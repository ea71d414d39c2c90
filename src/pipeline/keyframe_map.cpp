#include "keyframe_map.hpp"

#include "deja_view/base/check.hpp"

#include <cstdlib>
#include <utility>

namespace deja_view {
namespace {

constexpr std::int64_t kSameStampNs = 500;

}  // namespace

KeyframeMap::KeyframeMap(std::vector<StoredKeyframe> keyframes, PoseGraph graph)
    : keyframes_(std::move(keyframes)), graph_(std::move(graph)) {
  DEJA_VIEW_CHECK_OP(static_cast<int>(keyframes_.size()), ==, graph_.size());
  for (int i = 0; i < size(); ++i) {
    stamps_[(*this)[i].stamp_ns] = i;
    if ((*this)[i].is_place) {
      places_.push_back(i);
    }
  }
}

int KeyframeMap::Add(StoredKeyframe keyframe, int sequence, const Rigid3& T_W_B) {
  const int index = graph_.AddNode(sequence, T_W_B);
  DEJA_VIEW_CHECK(!keyframe.is_place);
  stamps_[keyframe.stamp_ns] = index;
  keyframes_.push_back(std::move(keyframe));
  return index;
}

void KeyframeMap::MakePlace(KeyframeFeatures features) {
  StoredKeyframe& keyframe = keyframes_.back();
  DEJA_VIEW_CHECK(!keyframe.is_place);
  keyframe.is_place = true;
  keyframe.features = std::move(features);
  places_.push_back(newest());
}

KeyframeFeatures& KeyframeMap::features(int i) {
  StoredKeyframe& keyframe = keyframes_.at(static_cast<std::size_t>(i));
  DEJA_VIEW_CHECK(keyframe.is_place);
  return keyframe.features;
}

bool KeyframeMap::IsSameStamp(std::int64_t a_ns, std::int64_t b_ns) {
  return std::abs(a_ns - b_ns) <= kSameStampNs;
}

std::optional<int> KeyframeMap::At(std::int64_t stamp_ns) const {
  std::optional<int> found;
  std::int64_t nearest = kSameStampNs + 1;
  for (auto it = stamps_.lower_bound(stamp_ns - kSameStampNs);
       it != stamps_.end() && it->first <= stamp_ns + kSameStampNs;
       ++it) {
    const std::int64_t distance = std::abs(it->first - stamp_ns);
    if (distance < nearest) {
      nearest = distance;
      found = it->second;
    }
  }
  return found;
}

}  // namespace deja_view
