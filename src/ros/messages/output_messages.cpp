#include "deja_view/ros/messages/output_messages.hpp"

#include <algorithm>
#include <array>

namespace deja_view {
namespace {

geometry_msgs::Point ToPoint(const Eigen::Vector3d& p) {
  geometry_msgs::Point point;
  point.x = p.x();
  point.y = p.y();
  point.z = p.z();
  return point;
}

visualization_msgs::Marker MakeMarker(int type,
                                      const std::string& name,
                                      std::int64_t stamp_ns,
                                      double width_m,
                                      const std::array<float, 3>& rgb,
                                      const FrameNames& frames) {
  visualization_msgs::Marker marker;
  marker.header.frame_id = frames.map;
  marker.header.stamp = ToRosTime(stamp_ns);
  marker.ns = name;
  marker.type = type;
  marker.action = visualization_msgs::Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = width_m;
  marker.scale.y = width_m;
  marker.scale.z = width_m;
  marker.color.r = rgb[0];
  marker.color.g = rgb[1];
  marker.color.b = rgb[2];
  marker.color.a = 1.0F;
  return marker;
}

std::int64_t NewestStamp(const std::vector<KeyframeInfo>& keyframes) {
  return keyframes.empty() ? 0 : keyframes.back().stamp_ns;
}

geometry_msgs::TransformStamped ToTransform(const Rigid3& T_parent_child,
                                            std::int64_t stamp_ns,
                                            const std::string& parent,
                                            const std::string& child) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = ToRosTime(stamp_ns);
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform.translation.x = T_parent_child.t.x();
  message.transform.translation.y = T_parent_child.t.y();
  message.transform.translation.z = T_parent_child.t.z();
  message.transform.rotation = ToPose(T_parent_child).orientation;
  return message;
}

}  // namespace

LoopConstraint ToLoopConstraint(const LoopReport& loop, const FrameNames& frames) {
  LoopConstraint message;
  message.header.stamp = ToRosTime(loop.stamp_current_ns);
  message.header.frame_id = frames.body;
  message.stamp_current = ToRosTime(loop.stamp_current_ns);
  message.stamp_old = ToRosTime(loop.stamp_old_ns);
  message.index_current = loop.current;
  message.index_old = loop.old;
  message.relative_pose.pose = ToPose(loop.T_Bold_Bcurrent);
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) {
      message.relative_pose.covariance[static_cast<std::size_t>(6 * row + column)] =
          loop.covariance(row, column);
    }
  }
  message.score = loop.score;
  message.matches = loop.matches;
  message.inliers = loop.inliers;
  message.is_virtual = loop.is_virtual;
  message.accepted = loop.accepted();
  message.reason = EnumToString(loop.reason);
  return message;
}

geometry_msgs::TransformStamped ToDrift(const Rigid3& T_M_W,
                                        std::int64_t stamp_ns,
                                        const FrameNames& frames) {
  return ToTransform(T_M_W, stamp_ns, frames.map, frames.vio);
}

geometry_msgs::TransformStamped ToCorrectedBody(const Rigid3& T_M_B,
                                                std::int64_t stamp_ns,
                                                const FrameNames& frames) {
  return ToTransform(T_M_B, stamp_ns, frames.map, frames.body_corrected);
}

nav_msgs::Odometry CorrectOdometry(const nav_msgs::Odometry& odometry,
                                   const StampedPose& T_W_B,
                                   const Rigid3& T_M_W,
                                   const FrameNames& frames) {
  nav_msgs::Odometry message = odometry;
  message.header.frame_id = frames.map;
  message.child_frame_id = frames.body;
  message.pose.pose = ToPose(T_M_W * T_W_B.pose);
  const auto& linear = odometry.twist.twist.linear;
  const Eigen::Vector3d v_M = T_M_W.q * Eigen::Vector3d(linear.x, linear.y, linear.z);
  message.twist.twist.linear.x = v_M.x();
  message.twist.twist.linear.y = v_M.y();
  message.twist.twist.linear.z = v_M.z();
  return message;
}

nav_msgs::Path ToPath(const std::vector<KeyframeInfo>& keyframes,
                      bool as_received,
                      const FrameNames& frames) {
  nav_msgs::Path path;
  path.header.frame_id = frames.map;
  path.header.stamp = ToRosTime(NewestStamp(keyframes));
  path.poses.reserve(keyframes.size());
  for (const KeyframeInfo& keyframe : keyframes) {
    geometry_msgs::PoseStamped pose;
    pose.header.frame_id = frames.map;
    pose.header.stamp = ToRosTime(keyframe.stamp_ns);
    pose.pose = ToPose(as_received ? keyframe.T_W_B : keyframe.T_M_B);
    path.poses.push_back(pose);
  }
  return path;
}

visualization_msgs::MarkerArray ToPoseGraphMarkers(const std::vector<KeyframeInfo>& keyframes,
                                                   const std::vector<LoopReport>& loops,
                                                   const FrameNames& frames) {
  const std::int64_t stamp = NewestStamp(keyframes);
  visualization_msgs::Marker lines = MakeMarker(
      visualization_msgs::Marker::LINE_LIST, "loops", stamp, 0.02, {0.9F, 0.3F, 0.1F}, frames);
  const auto at_or_after = [&](int index) {
    return std::lower_bound(
        keyframes.begin(), keyframes.end(), index, [](const KeyframeInfo& keyframe, int wanted) {
          return keyframe.index < wanted;
        });
  };
  for (const LoopReport& loop : loops) {
    const auto old = at_or_after(loop.old);
    const auto current = at_or_after(loop.current);
    if (old != keyframes.end() && current != keyframes.end()) {
      lines.points.push_back(ToPoint(old->T_M_B.t));
      lines.points.push_back(ToPoint(current->T_M_B.t));
    }
  }
  visualization_msgs::MarkerArray markers;
  markers.markers.push_back(std::move(lines));
  return markers;
}

visualization_msgs::Marker ToKeyframeMarker(const std::vector<KeyframeInfo>& keyframes,
                                            const FrameNames& frames) {
  visualization_msgs::Marker dots = MakeMarker(visualization_msgs::Marker::SPHERE_LIST,
                                               "key_odometrys",
                                               NewestStamp(keyframes),
                                               0.05,
                                               {0.1F, 0.7F, 0.3F},
                                               frames);
  for (const KeyframeInfo& keyframe : keyframes) {
    dots.points.push_back(ToPoint(keyframe.T_M_B.t));
  }
  return dots;
}

visualization_msgs::MarkerArray ToCameraMarkers(const Rigid3& T_M_C,
                                                const Camera& camera,
                                                double size_m,
                                                std::int64_t stamp_ns,
                                                const FrameNames& frames) {
  visualization_msgs::Marker lines = MakeMarker(visualization_msgs::Marker::LINE_LIST,
                                                "camera_pose_visual",
                                                stamp_ns,
                                                0.02,
                                                {0.1F, 0.4F, 0.9F},
                                                frames);
  const double right = size_m * camera.width() / (2.0 * camera.FocalLength());
  const double down = size_m * camera.height() / (2.0 * camera.FocalLength());
  const std::array<Eigen::Vector3d, 4> corners = {{{-right, -down, size_m},
                                                   {right, -down, size_m},
                                                   {right, down, size_m},
                                                   {-right, down, size_m}}};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const geometry_msgs::Point corner = ToPoint(T_M_C * corners[i]);
    lines.points.push_back(ToPoint(T_M_C.t));
    lines.points.push_back(corner);
    lines.points.push_back(corner);
    lines.points.push_back(ToPoint(T_M_C * corners[(i + 1) % corners.size()]));
  }
  visualization_msgs::MarkerArray markers;
  markers.markers.push_back(std::move(lines));
  return markers;
}

}  // namespace deja_view
