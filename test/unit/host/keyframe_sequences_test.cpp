// Where the assembler begins a new sequence.

#include "keyframe_assembler_fixture.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

TEST_F(KeyframeAssemblerTest, TwoPosesBackInARowAreARestart) {
  Reset({});
  for (const int start : {500000, 0}) {
    for (int ms = start; ms <= start + 1000; ms += 100) {
      Image(ms);
      if (ms >= start + 200) {
        Pose(ms - 200);
        Points(ms - 200);
      }
    }
  }
  EXPECT_EQ(output_.size(), 18U);
  EXPECT_EQ(output_[8].first, 500800);
  EXPECT_EQ(output_[9].first, 0);
  EXPECT_THAT(drops_, IsEmpty());
  EXPECT_THAT(sequence_starts_, ElementsAre(0));
}

TEST_F(KeyframeAssemblerTest, APauseOfTheImagesStartsASequence) {
  Reset({});
  for (const int ms : {0, 900, 1800, 2801, 2850}) {
    Keyframe(ms);
  }
  EXPECT_THAT(sequence_starts_, ElementsAre(2801));
}

TEST_F(KeyframeAssemblerTest, KeyframesFarApartOfACloseImageStreamDoNot) {
  Reset({});
  for (int ms = 0; ms <= 6000; ms += 100) {
    Image(ms);
    if (ms % 3000 == 0) {
      Pose(ms);
      Points(ms);
    }
  }
  EXPECT_EQ(output_.size(), 3U);
  EXPECT_THAT(sequence_starts_, IsEmpty());
}

TEST_F(KeyframeAssemblerTest, AStrayImageStampStartsNoSequence) {
  for (const int stray : {-400000, 5000}) {
    Reset({});
    for (int ms = 0; ms <= 9000; ms += 100) {
      Keyframe(ms);
      if (ms == 200) {
        Image(stray);
      }
    }
    EXPECT_EQ(output_.size(), 91U);
    EXPECT_THAT(sequence_starts_, IsEmpty()) << stray;
  }
}

TEST_F(KeyframeAssemblerTest, TheNextKeyframeStartsTheSequenceWhenItsFirstOneIsLost) {
  Reset({});
  Keyframe(0);
  Image(3000);
  Pose(3100);  // its image is lost
  Keyframe(3200);
  Keyframe(3300);
  EXPECT_THAT(sequence_starts_, ElementsAre(3200));
}

TEST_F(KeyframeAssemblerTest, AVioThatStartsAnewUnderItsTracksStartsASequence) {
  Reset({});
  const auto keyframe = [this](int ms, double shift_m) {
    std::vector<TrackedPoint> points(20);
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].feature_id = static_cast<std::int64_t>(i);
      points[i].p_W = {5 + shift_m, 0.1 * static_cast<double>(i), 0};
    }
    Image(ms);
    assembler_.AddPose(Stamp(ms), {Eigen::Quaterniond::Identity(), {shift_m, 0, 0}});
    assembler_.AddPoints(Stamp(ms), points);
  };
  keyframe(0, 0);
  keyframe(200, 0);
  keyframe(400, 4);
  keyframe(600, 4);
  EXPECT_THAT(sequence_starts_, ElementsAre(400));
  EXPECT_EQ(assembler_.counts().restarts, 1);
}

}  // namespace
}  // namespace deja_view
