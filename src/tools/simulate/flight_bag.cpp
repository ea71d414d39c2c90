#include "simulate/flight_bag.hpp"

#include "deja_view/ros/messages/conversions.hpp"
#include "deja_view/ros/messages/virtual_frame_conversion.hpp"

#include <utility>

#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>

namespace deja_view {
namespace {

template <typename Vector>
void Assign(const Eigen::Vector3d& from, Vector* to) {
  to->x = from.x();
  to->y = from.y();
  to->z = from.z();
}

}  // namespace

FlightBag::FlightBag(const std::filesystem::path& path,
                     std::shared_ptr<const Camera> camera,
                     const Rigid3& T_B_C)
    : writer_(path), camera_(std::move(camera)), T_B_C_(T_B_C) {}

void FlightBag::OnImu(const sim::ImuSample& sample) {
  sensor_msgs::Imu message;
  message.header.stamp = ToRosTime(sample.stamp_ns);
  message.header.frame_id = "imu0";
  message.orientation_covariance[0] = -1;  // no orientation is measured
  Assign(sample.gyro, &message.angular_velocity);
  Assign(sample.accel, &message.linear_acceleration);
  writer_.Write("/imu0", sample.stamp_ns, message);
}

void FlightBag::OnImage(std::int64_t stamp_ns, const cv::Mat& image) {
  writer_.Write("/cam0/image_raw", stamp_ns, ToImage(image, stamp_ns, "cam0"));
}

void FlightBag::OnOdometry(std::int64_t arrival_ns, const sim::VioOdometry& odometry) {
  nav_msgs::Odometry body = ToOdometry({odometry.stamp_ns, odometry.T_V_B});
  Assign(odometry.velocity_V, &body.twist.twist.linear);
  writer_.Write("/vins_estimator/odometry", arrival_ns, body);
  writer_.Write("/vins_estimator/camera_pose",
                arrival_ns,
                ToOdometry({odometry.stamp_ns, odometry.T_V_B * T_B_C_}));
  writer_.Write("/vins_estimator/extrinsic", arrival_ns, ToOdometry({odometry.stamp_ns, T_B_C_}));
}

void FlightBag::OnKeyframe(std::int64_t arrival_ns, const KeyframeInput& keyframe) {
  writer_.Write(
      "/vins_estimator/keyframe_pose", arrival_ns, ToOdometry({keyframe.stamp_ns, keyframe.T_W_B}));
  writer_.Write("/vins_estimator/keyframe_point",
                arrival_ns,
                ToKeyframePoints(keyframe.stamp_ns, keyframe.points, *camera_));
}

void FlightBag::AddVirtualView(std::int64_t arrival_ns, const VirtualView& view) {
  writer_.Write("/virtual_cam0/frame", arrival_ns, ToVirtualFrame(view, "cam0"));
}

}  // namespace deja_view
