#include "deja_view/lab/sim/simulator.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

#include "small_world.hpp"
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view::sim {
namespace {

/// Notes the order of calls.
class Log : public FlightSink {
 public:
  void OnImu(const ImuSample& sample) override { Note(sample.stamp_ns, "imu"); }
  void OnImage(std::int64_t stamp_ns, const cv::Mat& image) override {
    Note(stamp_ns, "image");
    sizes.push_back(image.size());
  }
  void OnOdometry(std::int64_t arrival_ns, const VioOdometry& odometry) override {
    Note(arrival_ns, "odometry");
    EXPECT_EQ(arrival_ns - odometry.stamp_ns, 50000000);
  }
  void OnKeyframe(std::int64_t arrival_ns, const KeyframeInput& keyframe) override {
    Note(arrival_ns, "keyframe");
    EXPECT_EQ(arrival_ns - keyframe.stamp_ns, 200000000);
  }

  std::map<std::string, int> counts;
  std::vector<cv::Size> sizes;

 private:
  void Note(std::int64_t arrival_ns, const std::string& what) {
    EXPECT_GE(arrival_ns, last_ns_) << what;
    last_ns_ = arrival_ns;
    ++counts[what];
  }
  std::int64_t last_ns_ = 0;
};

TEST(Simulator, DeliversInOrderAtTheAskedRates) {
  const Simulator simulator(TinyOptions(), TinyWorld());
  Log log;
  std::size_t done = 0;
  simulator.Run(&log, [&](std::size_t d, std::size_t total) {
    EXPECT_EQ(d, ++done);
    EXPECT_EQ(total, simulator.image_count());
  });
  EXPECT_EQ(log.counts["imu"], 1201);
  EXPECT_EQ(log.counts["image"], 60);
  EXPECT_EQ(log.counts["odometry"], 60);
  EXPECT_GT(log.counts["keyframe"], 25);
  EXPECT_EQ(log.sizes.front(), cv::Size(188, 120));
}

TEST(Simulator, SameSeedSameFlightOnAnyNumberOfThreads) {
  SimOptions options = TinyOptions();
  options.flight.duration_s = 3;
  const RecordedFlight a = Record(Simulator(options, TinyWorld()));
  options.threads = 3;
  const RecordedFlight b = Record(Simulator(options));
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size());
  for (std::size_t i = 0; i < a.keyframes.size(); ++i) {
    EXPECT_EQ(cv::norm(a.keyframes[i].image, b.keyframes[i].image, cv::NORM_INF), 0);
    ASSERT_EQ(a.keyframes[i].points.size(), b.keyframes[i].points.size());
    for (std::size_t k = 0; k < a.keyframes[i].points.size(); ++k) {
      EXPECT_EQ(a.keyframes[i].points[k].p_W, b.keyframes[i].points[k].p_W);
      EXPECT_EQ(a.keyframes[i].points[k].pixel, b.keyframes[i].points[k].pixel);
    }
  }
  options.flight_seed = 2;
  const RecordedFlight c = Record(Simulator(options, TinyWorld()));
  EXPECT_GT(cv::norm(a.keyframes[0].image, c.keyframes[0].image, cv::NORM_INF), 0);
}

TEST(Simulator, StopsWhenProgressThrows) {
  const Simulator simulator(TinyOptions(), TinyWorld());
  FlightSink sink;
  int calls = 0;
  EXPECT_THROW(simulator.Run(&sink,
                             [&](std::size_t /*done*/, std::size_t /*total*/) {
                               ++calls;
                               throw std::runtime_error("stop");
                             }),
               std::runtime_error);
  EXPECT_EQ(calls, 1);
}

TEST(Simulator, NamesInvalidOptions) {
  SimOptions options = TinyOptions();
  options.sensor.samples = 0;
  options.vio.drift_max = -1;
  try {
    Simulator simulator(options);
    FAIL() << "no exception";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("sensor.samples"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("vio.drift_max"), std::string::npos);
  }
}

TEST(Record, TruthBelongsToTheKeyframes) {
  SimOptions options = TinyOptions();
  options.flight.duration_s = 3;
  options.vio.drift_min = options.vio.drift_max = options.vio.tilt_noise_deg = 0;
  const Simulator simulator(options, TinyWorld());
  const RecordedFlight flight = Record(simulator);
  ASSERT_GT(flight.keyframes.size(), 3U);
  ASSERT_EQ(flight.keyframes.size(), flight.T_W_B.size());
  for (std::size_t i = 0; i < flight.keyframes.size(); ++i) {
    const Rigid3 expected = simulator.drift().T_V_W() * flight.T_W_B[i];
    // The odometry is interpolated between steps of 50 ms.
    EXPECT_LT((flight.keyframes[i].T_W_B.t - expected.t).norm(), 1e-3);
  }
}

}  // namespace
}  // namespace deja_view::sim
