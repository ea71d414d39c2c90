#include "deja_view/lab/sim/simulator.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/lab/sim/image_sensor.hpp"
#include "deja_view/lab/sim/vio_front_end.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

namespace deja_view::sim {
namespace {

constexpr double kNsPerSecond = 1e9;

const SimOptions& CheckedOptions(const SimOptions& options) {
  RejectAny(options.Validate(), "simulation options");
  return options;
}

/// Holds messages back until their time of arrival.
class DelayLine {
 public:
  void Add(std::int64_t arrival_ns, std::function<void()> deliver) {
    waiting_.emplace(arrival_ns, std::move(deliver));
  }
  void DeliverUntil(std::int64_t now_ns) {
    while (!waiting_.empty() && waiting_.begin()->first <= now_ns) {
      waiting_.begin()->second();
      waiting_.erase(waiting_.begin());
    }
  }
  void DeliverAll() {
    for (auto& [arrival, deliver] : waiting_) {
      deliver();
    }
    waiting_.clear();
  }

 private:
  std::multimap<std::int64_t, std::function<void()>> waiting_;
};

std::int64_t Nanoseconds(double seconds) {
  return std::llround(seconds * kNsPerSecond);
}

}  // namespace

Simulator::Simulator(const SimOptions& options)
    : Simulator(CheckedOptions(options),
                std::make_shared<World>(options.seed, options.world, options.threads)) {}

Simulator::Simulator(const SimOptions& options, std::shared_ptr<const World> world)
    : options_(CheckedOptions(options)),
      world_(std::move(world)),
      camera_(std::make_shared<PinholeCamera>(SimulatedCamera(options.camera))),
      renderer_(
          std::make_shared<Renderer>(world_, camera_, options.sensor.samples, options.threads)),
      path_(std::make_shared<FlightPath>(*world_, options.flight, options.flight_seed)),
      drift_(std::make_shared<VioDrift>(*path_, options.vio, options.flight_seed)) {}

/// Images begin when the first exposure fits into the flight.
double Simulator::ImageTime(std::size_t index) const {
  return 0.05 + static_cast<double>(index) / options_.sensor.image_rate_hz;
}

std::size_t Simulator::image_count() const {
  const double room = path_->duration() - 0.1;
  return static_cast<std::size_t>(room * options_.sensor.image_rate_hz) + 1;
}

std::int64_t Simulator::ImageStamp(std::size_t index) const {
  return options_.start_stamp_ns + Nanoseconds(ImageTime(index));
}

cv::Mat Simulator::RenderFrame(double t) const {
  const int samples = options_.sensor.samples;
  std::vector<Rigid3> T_W_C;
  for (int i = 0; i < samples; ++i) {
    const double within = (i + 0.5) / samples - 0.5;
    T_W_C.push_back(path_->Pose(t + within * 1e-3 * options_.sensor.exposure_ms) *
                    SimulatedExtrinsic());
  }
  return renderer_->RenderRadiance(T_W_C);
}

void Simulator::Run(FlightSink* sink,
                    const std::function<void(std::size_t, std::size_t)>& progress) const {
  DEJA_VIEW_CHECK(sink != nullptr);
  ImageSensor sensor(options_.sensor, *camera_, options_.flight_seed);
  VioFrontEnd front_end(world_, camera_, SimulatedExtrinsic(), options_.vio, options_.flight_seed);
  const auto imu = SimulateImu(*path_, options_.imu, options_.start_stamp_ns, options_.flight_seed);
  auto next_imu = imu.begin();
  DelayLine delayed;
  const auto deliver_until = [&](std::int64_t now_ns) {
    for (; next_imu != imu.end() && next_imu->stamp_ns <= now_ns; ++next_imu) {
      delayed.DeliverUntil(next_imu->stamp_ns);
      sink->OnImu(*next_imu);
    }
    delayed.DeliverUntil(now_ns);
  };
  for (std::size_t i = 0; i < image_count(); ++i) {
    const double t = ImageTime(i);
    VioFrame frame;
    frame.stamp_ns = ImageStamp(i);
    frame.T_W_B = path_->Pose(t);
    frame.T_V_B = drift_->Pose(t);
    frame.image = sensor.Expose(RenderFrame(t));
    deliver_until(frame.stamp_ns);
    sink->OnImage(frame.stamp_ns, frame.image);
    constexpr double kDelta = 0.01;  // [s]
    const Eigen::Vector3d moved = drift_->Pose(t + kDelta).t - drift_->Pose(t - kDelta).t;
    const VioOdometry odometry{frame.stamp_ns, frame.T_V_B, moved / (2 * kDelta)};
    const std::int64_t odometry_ns = frame.stamp_ns + Nanoseconds(options_.vio.odometry_delay_s);
    delayed.Add(odometry_ns, [=] { sink->OnOdometry(odometry_ns, odometry); });
    if (const auto keyframe = front_end.Process(frame)) {
      const std::int64_t arrival_ns = frame.stamp_ns + Nanoseconds(options_.vio.keyframe_delay_s);
      delayed.Add(arrival_ns, [=] { sink->OnKeyframe(arrival_ns, *keyframe); });
    }
    if (progress) {
      progress(i + 1, image_count());
    }
  }
  for (; next_imu != imu.end(); ++next_imu) {
    delayed.DeliverUntil(next_imu->stamp_ns);
    sink->OnImu(*next_imu);
  }
  delayed.DeliverAll();
}

RecordedFlight Record(const Simulator& simulator) {
  class Recorder : public FlightSink {
   public:
    void OnImu(const ImuSample& sample) override { flight.imu.push_back(sample); }
    void OnOdometry(std::int64_t /*arrival_ns*/, const VioOdometry& odometry) override {
      flight.odometry.push_back(odometry);
    }
    void OnKeyframe(std::int64_t /*arrival_ns*/, const KeyframeInput& keyframe) override {
      flight.keyframes.push_back(keyframe);
    }
    RecordedFlight flight;
  };
  Recorder recorder;
  simulator.Run(&recorder);
  RecordedFlight flight = std::move(recorder.flight);
  flight.camera = simulator.camera();
  flight.T_B_C = SimulatedExtrinsic();
  const std::int64_t start = simulator.options().start_stamp_ns;
  flight.ground_truth = simulator.path().GroundTruth(start);
  for (const KeyframeInput& keyframe : flight.keyframes) {
    flight.T_W_B.push_back(
        simulator.path().Pose(static_cast<double>(keyframe.stamp_ns - start) / kNsPerSecond));
  }
  return flight;
}

}  // namespace deja_view::sim
