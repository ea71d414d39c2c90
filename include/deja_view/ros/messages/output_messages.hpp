#pragma once

#include "deja_view/pipeline/loop_closer.hpp"
#include "deja_view/ros/messages/conversions.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include <deja_view/LoopConstraint.h>

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>

namespace deja_view {

/// Frame ids of what the node publishes.
struct FrameNames {
  std::string map = "world";                      ///< M; VINS-Mono's name for the world
  std::string vio = "vio";                        ///< W, before correction
  std::string body = "body";                      ///< B
  std::string body_corrected = "body_corrected";  ///< B, as tf's child of the map
};

LoopConstraint ToLoopConstraint(const LoopReport& loop, const FrameNames& frames);

/// Pose of the VIO's world in the map, which is its drift with opposite sign.
geometry_msgs::TransformStamped ToDrift(const Rigid3& T_M_W,
                                        std::int64_t stamp_ns,
                                        const FrameNames& frames);

/// The corrected pose of the body, for tf.
geometry_msgs::TransformStamped ToCorrectedBody(const Rigid3& T_M_B,
                                                std::int64_t stamp_ns,
                                                const FrameNames& frames);

/// The VIO's odometry moved into the map: pose, and velocity, which VINS-Mono gives in W.
/// Covariances are kept.
nav_msgs::Odometry CorrectOdometry(const nav_msgs::Odometry& odometry,
                                   const StampedPose& T_W_B,
                                   const Rigid3& T_M_W,
                                   const FrameNames& frames);

/// Corrected poses (or, with `as_received`, the VIO's) of the keyframes.
nav_msgs::Path ToPath(const std::vector<KeyframeInfo>& keyframes,
                      bool as_received,
                      const FrameNames& frames);

/// Lines between the ends of the loops; `keyframes` by index.
visualization_msgs::MarkerArray ToPoseGraphMarkers(const std::vector<KeyframeInfo>& keyframes,
                                                   const std::vector<LoopReport>& loops,
                                                   const FrameNames& frames);

/// Dots at the keyframes' corrected positions.
visualization_msgs::Marker ToKeyframeMarker(const std::vector<KeyframeInfo>& keyframes,
                                            const FrameNames& frames);

/// The camera as a pyramid of depth `size_m`.
visualization_msgs::MarkerArray ToCameraMarkers(const Rigid3& T_M_C,
                                                const Camera& camera,
                                                double size_m,
                                                std::int64_t stamp_ns,
                                                const FrameNames& frames);

}  // namespace deja_view
