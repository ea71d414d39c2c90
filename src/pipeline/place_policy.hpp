#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/pipeline/loop_closer_options.hpp"
#include "deja_view/verification/loop_verifier.hpp"

#include <memory>
#include <vector>

#include "candidates.hpp"

namespace deja_view {

/// Decides which keyframes become places to recognise. With a spacing in metres: those that have no
/// other place within `spacing_m` [m] and `spacing_deg` [deg], all when it is 0. Below 0: those
/// whose points no single place covers, so that one rule serves a hall and a desk. A single one,
/// since a loop ties a keyframe to one place and needs enough of it there.
class PlacePolicy {
 public:
  PlacePolicy(double spacing_m,
              double spacing_deg,
              const PlaceCoverOptions& cover,
              std::shared_ptr<const Camera> camera);

  /// `here` is the keyframe's camera, `seen` what it sees, `places` the cameras of all places in
  /// its world.
  bool IsNewPlace(const NearbyPlace& here,
                  const KeyframeFeatures& seen,
                  const std::vector<NearbyPlace>& places) const;

 private:
  using Points = std::vector<Eigen::Vector3d>;

  bool IsSpacedFrom(const NearbyPlace& place, const NearbyPlace& here) const;
  /// Some of a keyframe's points in its camera's frame [m], spread over all; where it has too few,
  /// a grid over its image at their median depth.
  Points Sample(const KeyframeFeatures& seen) const;
  bool Covers(const Rigid3& T_place_here, const Points& points_here) const;

  double spacing_m_;
  double min_axis_cosine_;
  PlaceCoverOptions cover_;
  double min_ray_cosine_;
  std::shared_ptr<const Camera> camera_;
};

}  // namespace deja_view
