#include "deja_view/host/keyframe_assembler.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "keyframe_assembler_fixture.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

// What a VIO makes of a stamp: ros::Time::toSec, and the constructor from seconds.
std::int64_t ThroughDoubleSeconds(std::int64_t stamp_ns) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const double seconds =
      static_cast<double>(stamp_ns / kSecond) + 1e-9 * static_cast<double>(stamp_ns % kSecond);
  const double whole = std::floor(seconds);
  return static_cast<std::int64_t>(whole) * kSecond +
         static_cast<std::int64_t>(std::round((seconds - whole) * 1e9));
}

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;

TEST_F(KeyframeAssemblerTest, MatchesInEveryOrderOfArrival) {
  std::vector<int> order = {0, 1, 2};
  do {
    Reset({});
    for (const int kind : order) {
      if (kind == 0) {
        Image(0);
      } else if (kind == 1) {
        Pose(0);
      } else {
        Points(0);
      }
    }
    EXPECT_THAT(output_, ElementsAre(Pair(0, 3)));
    EXPECT_THAT(drops_, IsEmpty());
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST_F(KeyframeAssemblerTest, DropsImagesOfNoKeyframeWithoutDecoding) {
  Reset({});
  for (int ms = 0; ms < 10000; ms += 50) {
    Image(ms);
    if (ms % 500 == 200) {
      Pose(ms - 200);
      Points(ms - 200);
    }
  }
  EXPECT_EQ(output_.size(), 20U);
  EXPECT_EQ(decoded_, 20);
  EXPECT_EQ(assembler_.counts().images, 200);
  EXPECT_THAT(drops_, IsEmpty());
}

TEST_F(KeyframeAssemblerTest, StampsMatchAfterATripThroughDoubleSeconds) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 10000; ++i) {
    const auto stamp = static_cast<std::int64_t>(random() % 4000000000000000000U);
    const std::int64_t through_double = ThroughDoubleSeconds(stamp);
    EXPECT_EQ(KeyframeAssembler::Key(stamp), through_double);
    EXPECT_EQ(KeyframeAssembler::Key(stamp), KeyframeAssembler::Key(through_double));
  }
  EXPECT_NE(KeyframeAssembler::Key(kStart), KeyframeAssembler::Key(kStart + 1000));

  Reset({});
  const std::int64_t sent_by_vio = KeyframeAssembler::Key(kStart + 1);
  ASSERT_NE(sent_by_vio, kStart + 1);
  assembler_.AddImage(
      kStart + 1, [] { return cv::Mat(2, 2, CV_8UC1); }, 4);
  assembler_.AddPose(sent_by_vio, Rigid3::Identity());
  assembler_.AddPoints(sent_by_vio, {});
  EXPECT_EQ(assembler_.counts().keyframes, 1);
}

TEST_F(KeyframeAssemblerTest, UsesAKeyframeWithoutItsPoints) {
  Reset({});
  Keyframe(0);
  Image(100);
  Pose(100);
  Keyframe(200);
  EXPECT_EQ(output_.size(), 1U);  // one later message may be a stray one
  Keyframe(300);
  EXPECT_THAT(output_, ElementsAre(Pair(0, 3), Pair(100, 0), Pair(200, 3), Pair(300, 3)));
  EXPECT_THAT(drops_, ElementsAre(Pair(DropReason::kMissingPoints, 100)));
  EXPECT_EQ(assembler_.counts().missing_points, 1);
}

TEST_F(KeyframeAssemblerTest, DropsAKeyframeWithoutItsImage) {
  Reset({});
  Keyframe(0);
  Pose(100);
  Points(100);
  Keyframe(200);
  Keyframe(300);
  EXPECT_THAT(output_, ElementsAre(Pair(0, 3), Pair(200, 3), Pair(300, 3)));
  EXPECT_THAT(drops_, ElementsAre(Pair(DropReason::kMissingImage, 100)));
}

TEST_F(KeyframeAssemblerTest, ASilentTopicHoldsKeyframesUpForTheTimeoutOnly) {
  KeyframeAssemblerOptions options;
  options.timeout_s = 1.0;
  Reset(options);
  for (int ms = 0; ms <= 1200; ms += 100) {
    Image(ms);
    Pose(ms);
  }
  EXPECT_THAT(output_, ElementsAre(Pair(0, 0)));
  assembler_.Flush();
  EXPECT_EQ(output_.size(), 13U);
}

TEST_F(KeyframeAssemblerTest, AStrayPoseIsDropped) {
  for (const int stray : {-400000, 400000, 5000, 150}) {
    Reset({});
    for (int ms = 0; ms <= 800; ms += 100) {
      Image(ms);
      if (ms >= 200) {
        Pose(ms - 200);
        if (ms == 400) {
          Pose(stray);
        }
      }
      if (ms >= 300) {
        Points(ms - 300);
      }
    }
    assembler_.Flush();
    EXPECT_THAT(output_,
                ElementsAre(Pair(0, 3),
                            Pair(100, 3),
                            Pair(200, 3),
                            Pair(300, 3),
                            Pair(400, 3),
                            Pair(500, 3),
                            Pair(600, 0)))
        << stray;
    EXPECT_THAT(
        drops_,
        ElementsAre(Pair(DropReason::kStrayStamp, stray), Pair(DropReason::kMissingPoints, 600)))
        << stray;
    EXPECT_THAT(sequence_starts_, IsEmpty()) << stray;
  }
}

TEST_F(KeyframeAssemblerTest, DropsDuplicates) {
  Reset({});
  Image(0);
  Image(0);
  Pose(0);
  Pose(0);
  Image(0);
  Points(0);
  Pose(0);
  Keyframe(100);
  Keyframe(200);
  EXPECT_THAT(output_, ElementsAre(Pair(0, 3), Pair(100, 3), Pair(200, 3)));
  EXPECT_EQ(assembler_.counts().duplicates, 4);
}

TEST_F(KeyframeAssemblerTest, BoundsHoldAndOverflowsAreCounted) {
  KeyframeAssemblerOptions options;
  options.image_memory_mb = 4;
  options.max_pending = 3;
  Reset(options);
  for (int ms = 0; ms < 600; ms += 100) {
    Image(ms);
  }
  EXPECT_THAT(drops_,
              ElementsAre(Pair(DropReason::kOverflow, 0), Pair(DropReason::kOverflow, 100)));
  drops_.clear();
  for (int ms = 200; ms < 600; ms += 100) {
    Pose(ms);
  }
  EXPECT_THAT(output_, ElementsAre(Pair(200, 0)));
  EXPECT_THAT(drops_,
              ElementsAre(Pair(DropReason::kOverflow, 200), Pair(DropReason::kMissingPoints, 200)));
}

TEST_F(KeyframeAssemblerTest, ALateVioFindsItsImages) {
  Reset({});
  for (int ms = 0; ms < 12000; ms += 100) {
    Image(ms);
  }
  for (const int ms : {500, 1000, 1500}) {
    Pose(ms);
    Points(ms);
  }
  assembler_.Flush();
  EXPECT_THAT(output_, ElementsAre(Pair(500, 3), Pair(1000, 3), Pair(1500, 3)));
  EXPECT_THAT(drops_, IsEmpty());
}

TEST_F(KeyframeAssemblerTest, ImagesOfALongHoverTakeNoMemory) {
  KeyframeAssemblerOptions options;
  options.image_memory_mb = 250;
  Reset(options);
  for (int rounds = 0; rounds < 3; ++rounds) {
    const int start = 20000 * rounds;
    for (int ms = start; ms < start + 20000; ms += 100) {
      Image(ms);
    }
    Pose(start + 19800);
    Points(start + 19800);
    Pose(start + 19900);
    Points(start + 19900);
  }
  EXPECT_EQ(output_.size(), 6U);
  EXPECT_EQ(assembler_.counts().overflows, 0);
}

TEST_F(KeyframeAssemblerTest, CalibrationIsThatOfTheKeyframesTime) {
  Reset({});
  Keyframe(0);
  Extrinsic(100, 1.0);
  Extrinsic(200, 1.0);
  Extrinsic(260, 7.0);
  Extrinsic(270, 8.0);
  Extrinsic(299, 1.01);
  Keyframe(90);
  Keyframe(250);
  Keyframe(300);
  EXPECT_THAT(extrinsics_, ElementsAre(-1.0, -1.0, 1.0, 1.01));
  EXPECT_EQ(assembler_.counts().extrinsic_jumps, 2);
  EXPECT_THAT(drops_, ElementsAre(Pair(DropReason::kExtrinsicJump, 260)));
}

// As OpenVINS sends it: whether it comes before or behind its keyframe makes no difference.
TEST_F(KeyframeAssemblerTest, ACalibrationOfEachKeyframeIsWaitedFor) {
  Reset({});
  Keyframe(0);
  Extrinsic(0, 1.0);
  Keyframe(50);
  Keyframe(100);
  EXPECT_EQ(output_.size(), 1U);
  Extrinsic(50, 1.01);
  Extrinsic(100, 1.02);
  EXPECT_EQ(output_.size(), 3U);
  Extrinsic(150, 1.03);
  Keyframe(150);
  EXPECT_THAT(extrinsics_, ElementsAre(-1.0, 1.0, 1.01, 1.02));
}

TEST_F(KeyframeAssemblerTest, ACalibrationThatStaysAwayHoldsUpTwoKeyframesOnce) {
  Reset({});
  Keyframe(0);
  Extrinsic(0, 1.0);
  Keyframe(50);
  Keyframe(100);
  EXPECT_EQ(output_.size(), 1U);
  Keyframe(150);
  EXPECT_EQ(output_.size(), 4U);
  Keyframe(200);
  EXPECT_THAT(extrinsics_, ElementsAre(-1.0, 1.0, 1.0, 1.0, 1.0));
}

TEST_F(KeyframeAssemblerTest, UnmatchedPointsAreCounted) {
  Reset({});
  Points(50);
  Keyframe(100);
  Keyframe(200);
  Keyframe(300);
  Points(60);
  EXPECT_THAT(drops_,
              ElementsAre(Pair(DropReason::kUnmatched, 50), Pair(DropReason::kUnmatched, 60)));
}

// Messages of each topic stay in their order, topics are shifted against each other at random, and
// some messages are lost or sent twice: the same keyframes must come out.
TEST_F(KeyframeAssemblerTest, OutputDoesNotDependOnHowTopicsInterleave) {
  struct Event {
    double arrival_ms;
    int kind;
    int ms;
  };
  std::mt19937 random(7);
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::vector<Event> sent;
  for (int ms = 0; ms < 20000; ms += 50) {
    const bool is_keyframe = ms % 150 == 0;
    if (uniform(0, 1) > 0.05) {
      sent.push_back({0, 0, ms});
    }
    for (const int kind : {1, 2}) {
      if (is_keyframe && uniform(0, 1) > 0.05) {
        sent.push_back({0, kind, ms});
        if (uniform(0, 1) < 0.05) {
          sent.push_back({0, kind, ms});
        }
      }
    }
  }
  Output expected;
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Event> events = sent;
    double newest[3] = {0, 0, 0};
    for (Event& event : events) {
      const double delay = event.kind == 0 ? 0.0 : 200.0;
      newest[event.kind] =
          std::max(newest[event.kind], event.ms + delay + (trial == 0 ? 0 : uniform(0, 700)));
      event.arrival_ms = newest[event.kind];
    }
    std::stable_sort(events.begin(), events.end(), [](const Event& a, const Event& b) {
      return a.arrival_ms < b.arrival_ms;
    });
    Reset({});
    for (const Event& event : events) {
      event.kind == 0 ? Image(event.ms) : event.kind == 1 ? Pose(event.ms) : Points(event.ms);
    }
    assembler_.Flush();
    if (trial == 0) {
      expected = output_;
      EXPECT_GT(expected.size(), 110U);
      EXPECT_LT(expected.size(), 130U);
    }
    ASSERT_EQ(output_, expected) << "trial " << trial;
  }
}

TEST(KeyframeAssemblerOptionsTest, ListsAllViolations) {
  EXPECT_THAT(KeyframeAssemblerOptions().Validate(), IsEmpty());
  KeyframeAssemblerOptions options;
  options.image_memory_mb = 0;
  options.timeout_s = -1;
  EXPECT_THAT(options.Validate(),
              ElementsAre(HasSubstr("image_memory_mb"), HasSubstr("timeout_s")));
  EXPECT_THROW(KeyframeAssembler(
                   options, [](const AssembledKeyframe&) {}, nullptr),
               InputError);
}

}  // namespace
}  // namespace deja_view
