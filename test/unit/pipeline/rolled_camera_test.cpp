// A camera that is rolled against the one that saw the place before, as on a drone that leans into
// a curve or in a hand.
#include "deja_view/base/angles.hpp"

#include <algorithm>
#include <vector>

#include "small_flight.hpp"
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

/// What a camera turned clockwise about its axis by `angle` would have handed over.
KeyframeInput Rolled(const KeyframeInput& level, double angle) {
  const sim::RecordedFlight& flight = test::SmallFlight(1);
  const auto& lens = flight.camera->parameters();
  KeyframeInput rolled = level;
  const Rigid3 roll{Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())),
                    Eigen::Vector3d::Zero()};
  rolled.T_W_B = level.T_W_B * flight.T_B_C * roll * flight.T_B_C.Inverse();
  const cv::Mat to_rolled =
      cv::getRotationMatrix2D(cv::Point2d(lens.cx, lens.cy), angle / kDegree, 1.0);
  rolled.image = cv::Mat();  // not into the flight's own
  cv::warpAffine(level.image, rolled.image, to_rolled, level.image.size());
  rolled.points.clear();
  for (TrackedPoint point : level.points) {
    const cv::Matx23d M = to_rolled;
    const cv::Vec2d pixel = M * cv::Vec3d(point.pixel.x(), point.pixel.y(), 1.0);
    point.pixel = Eigen::Vector2d(pixel[0], pixel[1]).cast<float>();
    if (flight.camera->IsInImage(point.pixel.cast<double>())) {
      rolled.points.push_back(point);
    }
  }
  return rolled;
}

/// Loops from the second half of the flight, rolled, to the first; all must be right.
int LoopsOfARolledSecondHalf(PatchOrientation orientation) {
  constexpr double kRoll = 70 * kDegree;
  const sim::RecordedFlight& flight = test::SmallFlight(1);
  LoopCloserOptions options = test::FlightOptions();
  options.features.orientation = orientation;
  LoopCloser closer = test::MakeCloser(1, options);
  const std::size_t half = flight.keyframes.size() / 2;
  for (std::size_t i = 0; i < flight.keyframes.size(); ++i) {
    closer.AddKeyframe(i < half ? flight.keyframes[i] : Rolled(flight.keyframes[i], kRoll));
  }
  const Rigid3 roll_B =
      flight.T_B_C *
      Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(kRoll, Eigen::Vector3d::UnitZ())),
             Eigen::Vector3d::Zero()} *
      flight.T_B_C.Inverse();
  int count = 0;
  for (const LoopReport& loop : closer.accepted_loops()) {
    if (loop.current < static_cast<int>(half) || loop.old >= static_cast<int>(half)) {
      continue;
    }
    ++count;
    const Rigid3 truth = flight.T_W_B[static_cast<std::size_t>(loop.old)].Inverse() *
                         flight.T_W_B[static_cast<std::size_t>(loop.current)] * roll_B;
    EXPECT_LT((loop.T_Bold_Bcurrent.t - truth.t).norm(), 0.3);
    EXPECT_LT(RotationAngle(loop.T_Bold_Bcurrent.q.conjugate() * truth.q), 3 * kDegree);
  }
  return count;
}

TEST(RolledCamera, RecognisesWhatALevelOneSaw) {
  const int with_gravity = LoopsOfARolledSecondHalf(PatchOrientation::kGravity);
  const int without = LoopsOfARolledSecondHalf(PatchOrientation::kImage);
  EXPECT_GE(with_gravity, 10);
  EXPECT_GT(with_gravity, 2 * without);
}

}  // namespace
}  // namespace deja_view
