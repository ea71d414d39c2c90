#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/verification/keyframe_features.hpp"
#include "deja_view/verification/relative_pose.hpp"

#include <cstddef>
#include <vector>

namespace deja_view::internal {

constexpr float kGridCellPx = 32.0F;  ///< of the grids that keypoints are looked up in

/// Points of one keyframe looked for in an image of the other; each with its camera.
struct LoopLink {
  const KeyframeFeatures* points;
  const Camera* points_camera;
  const KeyframeFeatures* image;
  const Camera* image_camera;
  bool is_reverse;                       ///< points of the old keyframe in the current image
  int camera = PixelMatch::kRealCamera;  ///< of the old keyframe
};

/// Point `point` of a link's points seen as keypoint `keypoint` of its image.
struct LoopMatch {
  int point = -1;
  int keypoint = -1;
  std::size_t link = 0;
};

struct LoopProblem {
  std::vector<PointObservation> observations;
  std::vector<LoopMatch> matches;          ///< per observation
  std::vector<std::vector<bool>> visible;  ///< per link: points that fall into the image
};

/// Two keyframes: the links between their cameras, the two real ones first.
struct LoopPair {
  std::vector<LoopLink> links;
  GravityPair gravity;

  bool has_rig() const { return links.size() > 2; }
};

}  // namespace deja_view::internal
