#include "deja_view/lab/sim/vio_front_end.hpp"

#include "deja_view/lab/sim/flight_path.hpp"
#include "deja_view/lab/sim/image_sensor.hpp"
#include "deja_view/lab/sim/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "small_world.hpp"
#include <gtest/gtest.h>

namespace deja_view::sim {
namespace {

/// Flies a few seconds at half resolution with an odometry that does not drift, V being W.
class VioFrontEndTest : public ::testing::Test {
 protected:
  struct Step {
    Rigid3 T_W_C;
    KeyframeInput keyframe;
    std::map<std::int64_t, Eigen::Vector3d> truth;
  };

  VioFrontEndTest() : camera_(std::make_shared<PinholeCamera>(SimulatedCamera({0.5}))) {}

  std::vector<Step> Fly(const VioOptions& options, double seconds) {
    const Rigid3 T_B_C = SimulatedExtrinsic();
    const Renderer renderer(TinyWorld(), camera_, 1, 1);
    const FlightPath path(*TinyWorld(), TinyOptions().flight, 1);
    ImageSensor sensor(SensorOptions(), *camera_, 1);
    VioFrontEnd front_end(TinyWorld(), camera_, T_B_C, options, 1);
    std::vector<Step> steps;
    for (double t = 0; t < seconds; t += 0.1) {
      const Rigid3 T_W_B = path.Pose(t);
      const cv::Mat image = sensor.Expose(renderer.RenderRadiance(T_W_B * T_B_C));
      const VioFrame frame{std::llround(t * 1e9), T_W_B, T_W_B, image};
      auto keyframe = front_end.Process(frame);
      EXPECT_LE(front_end.track_count(), options.max_points);
      if (!keyframe) {
        continue;
      }
      Step& step = steps.emplace_back(Step{T_W_B * T_B_C, *keyframe, {}});
      for (const TrackedPoint& point : keyframe->points) {
        if (const auto p_W = front_end.TruePoint(point.feature_id)) {
          step.truth[point.feature_id] = *p_W;
        }
      }
    }
    return steps;
  }

  std::shared_ptr<const PinholeCamera> camera_;
};

TEST_F(VioFrontEndTest, PointsProjectToTheirPixels) {
  VioOptions options;
  options.outlier_fraction = 0;
  std::vector<double> tracked;
  std::vector<double> triangulated;
  for (const Step& step : Fly(options, 5)) {
    for (const TrackedPoint& point : step.keyframe.points) {
      const Eigen::Vector2d pixel = point.pixel.cast<double>();
      const Rigid3 T_C_W = step.T_W_C.Inverse();
      const auto truth = camera_->Project(T_C_W * step.truth.at(point.feature_id));
      const auto estimate = camera_->Project(T_C_W * point.p_W);
      ASSERT_TRUE(truth && estimate);
      tracked.push_back((*truth - pixel).norm());
      triangulated.push_back((*estimate - pixel).norm());
    }
  }
  ASSERT_GT(tracked.size(), 1000U);
  std::sort(tracked.begin(), tracked.end());
  std::sort(triangulated.begin(), triangulated.end());
  // The length of a 2-D normal vector with 0.3 px per axis: median 0.353 px, 99 % below 0.91 px.
  EXPECT_NEAR(tracked[tracked.size() / 2], 0.353, 0.03);
  EXPECT_LT(tracked[tracked.size() * 99 / 100], 1.0);
  EXPECT_LT(triangulated[triangulated.size() / 2], 0.7);
  EXPECT_LT(triangulated[triangulated.size() * 9 / 10], 1.5);
}

TEST_F(VioFrontEndTest, DepthErrorGrowsWithDepthAndFallsWithTrackLength) {
  VioOptions options;
  options.outlier_fraction = 0;
  std::map<std::int64_t, int> seen;
  std::vector<double> near, far, early, late;
  for (const Step& step : Fly(options, 6)) {
    for (const TrackedPoint& point : step.keyframe.points) {
      const Eigen::Vector3d truth = step.truth.at(point.feature_id);
      const double range = (truth - step.T_W_C.t).norm();
      const double error = (point.p_W - truth).norm();
      const int times = ++seen[point.feature_id];
      (range < 3 ? near : far).push_back(error);
      (times <= 2 ? early : late).push_back(error / (range * range));
    }
  }
  const auto median = [](std::vector<double>* values) {
    std::sort(values->begin(), values->end());
    return (*values)[values->size() / 2];
  };
  ASSERT_GT(std::min({near.size(), far.size(), early.size(), late.size()}), 80U);
  EXPECT_GT(median(&far), 1.5 * median(&near));
  EXPECT_GT(median(&early), 1.5 * median(&late));
}

TEST_F(VioFrontEndTest, TracksPersistAndKeepTheirDistanceAtBirth) {
  std::map<std::int64_t, int> length;
  for (const Step& step : Fly(VioOptions(), 6)) {
    std::set<std::int64_t> ids;
    for (const TrackedPoint& point : step.keyframe.points) {
      EXPECT_TRUE(ids.insert(point.feature_id).second);
      EXPECT_TRUE(camera_->IsInImage(point.pixel.cast<double>(), 1.0));
      ++length[point.feature_id];
    }
  }
  int longest = 0;
  for (const auto& [id, count] : length) {
    longest = std::max(longest, count);
  }
  EXPECT_GT(longest, 15);
  EXPECT_GT(length.size(), 120U);
}

TEST_F(VioFrontEndTest, OutliersAreAsManyAsAsked) {
  VioOptions options;
  options.outlier_fraction = 0.2;
  std::size_t points = 0;
  std::size_t inliers = 0;
  for (const Step& step : Fly(options, 6)) {
    points += step.keyframe.points.size();
    inliers += step.truth.size();
  }
  const double share = 1.0 - static_cast<double>(inliers) / static_cast<double>(points);
  EXPECT_GT(share, 0.1);
  EXPECT_LT(share, 0.3);
}

TEST_F(VioFrontEndTest, StandingStillMakesNoKeyframes) {
  const Rigid3 T_W_B = LookAlong(*TinyWorld(), 2.0) * SimulatedExtrinsic().Inverse();
  const Renderer renderer(TinyWorld(), camera_, 1, 1);
  ImageSensor sensor(SensorOptions(), *camera_, 1);
  VioFrontEnd front_end(TinyWorld(), camera_, SimulatedExtrinsic(), VioOptions(), 1);
  const cv::Mat image = sensor.Expose(renderer.RenderRadiance(T_W_B * SimulatedExtrinsic()));
  int keyframes = 0;
  for (int i = 0; i < 10; ++i) {
    keyframes += front_end.Process({i * 100000000LL, T_W_B, T_W_B, image}) ? 1 : 0;
  }
  EXPECT_EQ(keyframes, 1);
}

}  // namespace
}  // namespace deja_view::sim
