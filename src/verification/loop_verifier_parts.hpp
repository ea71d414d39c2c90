#pragma once

#include "deja_view/verification/loop_verifier.hpp"

#include <vector>

namespace deja_view {

constexpr float kGridCellPx = 32.0F;  ///< of the grids that keypoints are looked up in

/// Points of one keyframe looked for in an image of the other; each with its camera.
struct LoopVerifier::Link {
  const KeyframeFeatures* points;
  const Camera* points_camera;
  const KeyframeFeatures* image;
  const Camera* image_camera;
  bool is_reverse;  ///< points of the old keyframe in the current image
};

/// Point `point` of a link's points seen as keypoint `keypoint` of its image.
struct LoopVerifier::Match {
  int point = -1;
  int keypoint = -1;
  std::size_t link = 0;
};

struct LoopVerifier::Problem {
  std::vector<PointObservation> observations;
  std::vector<Match> matches;              ///< per observation
  std::vector<std::vector<bool>> visible;  ///< per link: points that fall into the image
};

/// Two keyframes: the links between their cameras, the two real ones first.
struct LoopVerifier::Pair {
  std::vector<Link> links;
  GravityPair gravity;

  bool has_rig() const { return links.size() > 2; }
};

}  // namespace deja_view
