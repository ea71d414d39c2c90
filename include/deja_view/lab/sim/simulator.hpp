#pragma once

#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/host/keyframe_input.hpp"
#include "deja_view/lab/sim/flight_path.hpp"
#include "deja_view/lab/sim/imu.hpp"
#include "deja_view/lab/sim/options.hpp"
#include "deja_view/lab/sim/renderer.hpp"
#include "deja_view/lab/sim/vio_drift.hpp"
#include "deja_view/lab/sim/world.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view::sim {

/// One pose of the odometry, in its own world V.
struct VioOdometry {
  std::int64_t stamp_ns = 0;
  Rigid3 T_V_B;
  Eigen::Vector3d velocity_V = Eigen::Vector3d::Zero();  ///< [m/s]
};

/// Receives a flight as its messages arrive: `arrival_ns` never goes back over all calls. The first
/// image is preceded by OnExtrinsic. Images are not changed after the call and may be kept.
class FlightSink {
 public:
  virtual ~FlightSink() = default;
  virtual void OnImu(const ImuSample& /*sample*/) {}
  virtual void OnImage(std::int64_t /*stamp_ns*/, const cv::Mat& /*image*/) {}
  virtual void OnOdometry(std::int64_t /*arrival_ns*/, const VioOdometry& /*odometry*/) {}
  virtual void OnKeyframe(std::int64_t /*arrival_ns*/, const KeyframeInput& /*keyframe*/) {}
};

/// A hall with a flight through it; renders and tracks on demand.
class Simulator {
 public:
  /// Throws InputError with all violations when the options are not valid, or no flight fits the
  /// hall.
  explicit Simulator(const SimOptions& options);
  /// A flight through a hall that exists already; `options.world` and `options.seed` are not used.
  Simulator(const SimOptions& options, std::shared_ptr<const World> world);

  const SimOptions& options() const { return options_; }
  std::shared_ptr<const World> world() const { return world_; }
  std::shared_ptr<const PinholeCamera> camera() const { return camera_; }
  const Renderer& renderer() const { return *renderer_; }
  const FlightPath& path() const { return *path_; }
  const VioDrift& drift() const { return *drift_; }

  std::size_t image_count() const;
  std::int64_t ImageStamp(std::size_t index) const;

  /// Makes the whole flight; calls `progress(done, total)` after every image, which may throw to
  /// stop.
  void Run(FlightSink* sink,
           const std::function<void(std::size_t done, std::size_t total)>& progress = {}) const;

 private:
  double ImageTime(std::size_t index) const;
  cv::Mat RenderFrame(double t) const;

  SimOptions options_;
  std::shared_ptr<const World> world_;
  std::shared_ptr<const PinholeCamera> camera_;
  std::shared_ptr<const Renderer> renderer_;
  std::shared_ptr<const FlightPath> path_;
  std::shared_ptr<const VioDrift> drift_;
};

/// A whole flight in memory, for tests and small experiments.
struct RecordedFlight {
  std::shared_ptr<const PinholeCamera> camera;
  Rigid3 T_B_C;
  std::vector<KeyframeInput> keyframes;
  std::vector<Rigid3> T_W_B;  ///< truth of each keyframe
  std::vector<VioOdometry> odometry;
  std::vector<ImuSample> imu;
  Trajectory ground_truth;
};

/// Runs `simulator` and keeps all but the images that are no keyframe's.
RecordedFlight Record(const Simulator& simulator);

}  // namespace deja_view::sim
