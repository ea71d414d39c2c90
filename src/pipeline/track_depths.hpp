#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/host/keyframe_input.hpp"
#include "deja_view/pipeline/loop_closer_options.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

namespace deja_view {

/// A point of a keyframe whose place in the body frame is known.
struct LocatedPoint {
  Eigen::Vector3f p_B = Eigen::Vector3f::Zero();    ///< [m]
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();  ///< [px]
  float depth_sigma = 0;                            ///< [m] along the camera's ray
  std::int64_t id = -1;                             ///< of its track
};

/// Where the points that a VIO tracks are, and how well their depth is known: that follows from the
/// parallax over their track.
class TrackDepths {
 public:
  TrackDepths(const TrackDepthOptions& options, std::shared_ptr<const Camera> camera)
      : options_(options), camera_(std::move(camera)) {}

  /// The next keyframe's points, in their order, without those that are not finite or do not fit
  /// their pixel. A track ends with the first keyframe that does not show it.
  std::vector<LocatedPoint> Locate(const std::vector<TrackedPoint>& points,
                                   const Rigid3& T_W_B,
                                   const Rigid3& T_B_C);

  /// Another world, and perhaps the same ids.
  void Clear() { first_centres_W_.clear(); }

 private:
  /// In the camera's frame: its distance from the VIO's landmark, its direction from where it was
  /// tracked in this very image. Nothing for a point that does not fit its pixel.
  std::optional<Eigen::Vector3d> InCamera(const TrackedPoint& point, const Rigid3& T_C_W) const;
  /// [m] for a point seen from `first_W` first and from `centre_W` now.
  double DepthSigma(const Eigen::Vector3d& p_W,
                    const Eigen::Vector3d& first_W,
                    const Eigen::Vector3d& centre_W) const;

  TrackDepthOptions options_;
  std::shared_ptr<const Camera> camera_;
  /// [m] Where each track of the newest keyframe was first seen from.
  std::unordered_map<std::int64_t, Eigen::Vector3d> first_centres_W_;
};

}  // namespace deja_view
