#include "loop_measurements.hpp"

#include "deja_view/base/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr int kLatency = 5;

std::vector<int> OldOf(const std::vector<LoopMeasurement>& measurements) {
  std::vector<int> old;
  for (const LoopMeasurement& measurement : measurements) {
    old.push_back(measurement.old);
  }
  return old;
}

/// The keyframe with which a measurement of 100's loop is used that comes while `newest` is.
int UsedWith(int newest) {
  LoopMeasurements measurements(kLatency);
  measurements.Add({1, 100, {}}, newest);
  int keyframe = newest;
  while (measurements.TakeDue(++keyframe).empty()) {
  }
  return keyframe;
}

TEST(LoopMeasurements, AreUsedWithAKeyframeThatDoesNotTellWhenTheyCame) {
  for (int newest = 100; newest < 105; ++newest) {
    EXPECT_EQ(UsedWith(newest), 105) << newest;
  }
  for (int newest = 105; newest < 110; ++newest) {
    EXPECT_EQ(UsedWith(newest), 110) << newest;
  }
}

TEST(LoopMeasurements, AreUsedOnceAndInTheirOrder) {
  LoopMeasurements measurements(kLatency);
  measurements.Add({1, 100, {}}, 101);
  measurements.Add({2, 101, {}}, 102);
  measurements.Add({3, 100, {}}, 103);
  EXPECT_THAT(measurements.TakeDue(104), IsEmpty());
  EXPECT_THAT(OldOf(measurements.TakeDue(105)), ElementsAre(1, 3));
  EXPECT_THAT(OldOf(measurements.TakeAll()), ElementsAre(2));
  EXPECT_THAT(measurements.TakeAll(), IsEmpty());
}

TEST(LoopMeasurements, AreOfAKeyframeThatIsThere) {
  LoopMeasurements measurements(kLatency);
  EXPECT_THROW(measurements.Add({1, 100, {}}, 99), CheckError);
}

}  // namespace
}  // namespace deja_view
