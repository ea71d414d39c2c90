#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/pipeline/loop_closer.hpp"

#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view {

/// Keeps small pictures of the newest keyframes (half size, JPEG, about 10 kB each) and shows loops
/// with them.
class MatchImages {
 public:
  /// `memory`: keyframes kept; 0 keeps none.
  explicit MatchImages(int memory) : memory_(memory) {}

  /// `index` counts up; one that does not means another map, and the pictures before are forgotten.
  /// Costs about half a millisecond.
  void Add(int index, const cv::Mat& grey);

  /// Old and current keyframe side by side (CV_8UC3), the points that they share joined by lines;
  /// nothing when the picture of one of them is not kept.
  std::optional<cv::Mat> Draw(const KeyframeInput& current,
                              int current_index,
                              const Relocalisation& relocalisation,
                              const Camera& camera) const;

 private:
  cv::Mat Picture(int index) const;

  int memory_;
  std::deque<std::pair<int, std::vector<std::uint8_t>>> pictures_;
};

}  // namespace deja_view
