#include "deja_view/lab/evaluation/relocalisation.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"

#include "looks_ahead.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

TrueKeyframe At(double x, double yaw_deg) {
  return {0, Rigid3{FromYaw(yaw_deg * kDegree), {x, 0, 0}}, false};
}

TEST(RelocalisationCurve, BinsByDistanceAndByAngle) {
  const std::vector<TrueKeyframe> places = {At(0, 0), At(10, 90), {}};
  const std::vector<TrueKeyframe> current = {
      At(0.2, 5),    // 0.2 m, 5 deg
      At(0.7, 23),   // 0.7 m, 23 deg
      At(0.9, 45),   // near, but turned: only by angle
      At(5.9, 0),    // far: only by distance
      At(6.1, 0),    // beyond the last bin
      At(10.6, 90),  // of the second place: 0.6 m, 0 deg
      {}             // no truth
  };
  const RelocalisationCurve curve = MakeRelocalisationCurve(
      places, current, {true, true, false, false, true, false, true}, kLooksAhead);
  ASSERT_EQ(curve.by_distance.size(), 12U);
  ASSERT_EQ(curve.by_angle.size(), 9U);
  const auto expect = [](const RelocalisationBin& bin, double from, int keyframes, int found) {
    EXPECT_DOUBLE_EQ(bin.from, from);
    EXPECT_EQ(bin.keyframes, keyframes) << from;
    EXPECT_EQ(bin.found, found) << from;
  };
  expect(curve.by_distance[0], 0.0, 1, 1);
  expect(curve.by_distance[1], 0.5, 2, 1);
  expect(curve.by_distance[2], 1.0, 0, 0);
  expect(curve.by_distance[11], 5.5, 1, 0);
  expect(curve.by_angle[0], 0.0, 2, 1);
  expect(curve.by_angle[2], 20.0, 1, 1);
  expect(curve.by_angle[4], 40.0, 1, 0);
  int counted = 0;
  for (const RelocalisationBin& bin : curve.by_angle) {
    counted += bin.keyframes;
  }
  EXPECT_EQ(counted, 4);
}

TEST(RelocalisationCurve, NeedsAnAnswerPerKeyframe) {
  EXPECT_THROW(MakeRelocalisationCurve({}, {At(0, 0)}, {}, kLooksAhead), CheckError);
  EXPECT_EQ(MakeRelocalisationCurve({}, {At(0, 0)}, {true}, kLooksAhead).by_distance[0].keyframes,
            0);
}

}  // namespace
}  // namespace deja_view
