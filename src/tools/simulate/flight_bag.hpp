#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/lab/sim/simulator.hpp"
#include "deja_view/ros/bag/bag_writer.hpp"
#include "deja_view/views/virtual_view.hpp"

#include <filesystem>
#include <memory>

namespace deja_view {

/// Writes a simulated flight as the bag that EuRoC's drone with VINS-Mono's front end on board
/// would record: /cam0/image_raw (mono8), /imu0 and /vins_estimator/{keyframe_pose, keyframe_point,
/// extrinsic, odometry, camera_pose}.
class FlightBag : public sim::FlightSink {
 public:
  FlightBag(const std::filesystem::path& path,
            std::shared_ptr<const Camera> camera,
            const Rigid3& T_B_C);

  void OnImu(const sim::ImuSample& sample) override;
  void OnImage(std::int64_t stamp_ns, const cv::Mat& image) override;
  void OnOdometry(std::int64_t arrival_ns, const sim::VioOdometry& odometry) override;
  void OnKeyframe(std::int64_t arrival_ns, const KeyframeInput& keyframe) override;

  /// As /virtual_cam0/frame.
  void AddVirtualView(std::int64_t arrival_ns, const VirtualView& view);

  /// Gives the bag its name; without it nothing is left behind.
  void Close() { writer_.Close(); }

 private:
  BagWriter writer_;
  std::shared_ptr<const Camera> camera_;
  Rigid3 T_B_C_;
};

}  // namespace deja_view
