#include "deja_view/pipeline/loop_closer.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "small_flight.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using test::DefaultOutcome;
using test::MakeCloser;
using test::SmallFlight;

/// The flight's second half as seen by a VIO that started anew: its own world, ids and drift.
KeyframeInput InAnotherWorld(KeyframeInput keyframe) {
  const Rigid3 T_V_W{FromYaw(1.0), {3, -2, 0.5}};
  keyframe.T_W_B = T_V_W * keyframe.T_W_B;
  for (TrackedPoint& point : keyframe.points) {
    point.p_W = T_V_W * point.p_W;
  }
  return keyframe;
}

TEST(LoopCloser, ASequenceThatStartsAnewIsJoinedByLoops) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  LoopCloser closer = MakeCloser(1);
  const std::size_t half = flight.keyframes.size() / 2;
  for (std::size_t i = 0; i < flight.keyframes.size(); ++i) {
    KeyframeInput keyframe = flight.keyframes[i];
    if (i >= half) {
      keyframe = InAnotherWorld(keyframe);
      keyframe.starts_sequence = i == half;
    }
    const KeyframeReport report = closer.AddKeyframe(keyframe);
    EXPECT_EQ(report.is_new_sequence, i == 0 || i == half);
    EXPECT_EQ(report.sequence, i < half ? 0 : 1);
    if (i == half) {
      EXPECT_FALSE(closer.is_joined(1));
      EXPECT_LT((closer.drift().t).norm(), 1e-12);
    }
  }
  ASSERT_TRUE(closer.is_joined(1));
  closer.OptimizeFully();
  EXPECT_EQ(closer.sequence_count(), 2);
  const KeyframeInfo last = closer.keyframe(closer.keyframe_count() - 1);
  const Rigid3 truth = flight.T_W_B.front().Inverse() * flight.T_W_B.back();
  EXPECT_LT((closer.keyframe(0).T_M_B.Inverse() * last.T_M_B * truth.Inverse()).t.norm(), 0.5);
  EXPECT_LT((closer.drift() * last.T_W_B.t - last.T_M_B.t).norm(), 1e-9);
}

/// A map with a kink: what its first third shows lies elsewhere than the rest says. A flight that
/// sees that first joins the map by it, and comes off it when more places of the rest contradict.
TEST(LoopCloser, AJoinThatProvesWrongIsTakenBack) {
  const std::vector<KeyframeInput>& flight = SmallFlight(1).keyframes;
  const std::size_t third = flight.size() / 6;
  LoopCloserOptions options = test::FlightOptions();
  options.consistency.min_span_over_depth = 0.2;
  LoopCloser closer = MakeCloser(1, options);
  for (std::size_t i = 0; i < flight.size() / 2; ++i) {
    closer.AddKeyframe(i < third ? InAnotherWorld(flight[i]) : flight[i]);
  }
  const int map_size = closer.keyframe_count();
  std::set<std::pair<int, int>> accepted;
  std::size_t withdrawn = 0;
  int taken_back = 0;
  for (std::size_t i = 0; i < flight.size(); ++i) {
    KeyframeInput keyframe = InAnotherWorld(flight[i]);
    keyframe.starts_sequence = i == 0;
    const KeyframeReport report = closer.AddKeyframe(keyframe);
    for (const LoopReport& loop : report.loops) {
      if (loop.reason == RejectReason::kWithdrawn && report.separates) {
        withdrawn += accepted.erase({loop.old, loop.current});
        EXPECT_LT(loop.old, static_cast<int>(third));
        EXPECT_EQ(loop.stamp_old_ns, flight[static_cast<std::size_t>(loop.old)].stamp_ns);
      } else if (loop.accepted() && loop.old < map_size) {
        accepted.emplace(loop.old, loop.current);
      }
    }
    if (report.separates) {
      ++taken_back;
      EXPECT_GT(withdrawn, 10U);
      EXPECT_TRUE(report.graph_changed);
    }
  }
  EXPECT_EQ(taken_back, 1);
  closer.OptimizeFully();
  // Most of the flight is where the rest of the map has it.
  const KeyframeInfo last = closer.keyframe(closer.keyframe_count() - 1);
  EXPECT_LT((last.T_M_B.t - flight.back().T_W_B.t).norm(), 1.0);
  for (const LoopReport& loop : closer.accepted_loops()) {
    EXPECT_GE(loop.old, static_cast<int>(third));
  }
}

TEST(LoopCloser, OwnPlacesDontHideAMapThatIsNotJoined) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  LoopCloserOptions options = test::FlightOptions();
  options.candidates.max_loops = 1;
  options.consistency.min_support_join = 1000;  // the two worlds stay apart
  LoopCloser closer = MakeCloser(1, options);
  for (const KeyframeInput& keyframe : flight.keyframes) {
    closer.AddKeyframe(keyframe);
  }
  int with_own_loop = 0;
  int with_map = 0;
  const int map_size = closer.keyframe_count();
  for (KeyframeInput keyframe : flight.keyframes) {
    keyframe = InAnotherWorld(keyframe);
    keyframe.starts_sequence = closer.keyframe_count() == map_size;
    const KeyframeReport report = closer.AddKeyframe(keyframe);
    if (report.reason == RejectReason::kNone) {
      ++with_own_loop;
      with_map += std::any_of(report.loops.begin(), report.loops.end(), [&](const auto& loop) {
        return loop.old < map_size;
      });
    }
  }
  EXPECT_FALSE(closer.is_joined(1));
  EXPECT_GT(with_own_loop, 5);
  EXPECT_EQ(with_map, with_own_loop);
}

TEST(LoopCloser, ANewSequenceForgetsTheTracksOfTheOneBefore) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  // Where loops are found at once, while tracks of the sequence before would still live.
  const auto start = static_cast<std::size_t>(DefaultOutcome().loops[20].current);
  const auto covariances = [&](std::int64_t id_offset) {
    LoopCloser closer = MakeCloser(1);
    for (std::size_t i = 0; i < flight.keyframes.size(); ++i) {
      KeyframeInput keyframe = flight.keyframes[i];
      if (i >= start) {
        keyframe = InAnotherWorld(keyframe);
        keyframe.starts_sequence = i == start;
        for (TrackedPoint& point : keyframe.points) {
          point.feature_id += id_offset;
        }
      }
      closer.AddKeyframe(keyframe);
    }
    std::vector<Matrix6d> list;
    for (const LoopReport& loop : closer.accepted_loops()) {
      list.push_back(loop.covariance);
    }
    return list;
  };
  // A VIO that starts anew may give its tracks the old numbers again.
  const auto expected = covariances(1'000'000);
  EXPECT_GT(expected.size(), 10U);
  EXPECT_TRUE(covariances(0) == expected);
}

TEST(LoopCloser, KnowsTheStartOfASequenceByItsStampAndPose) {
  const KeyframeInput first = SmallFlight(1).keyframes.front();
  LoopCloser closer = MakeCloser(1);
  closer.AddKeyframe(first);
  KeyframeInput next = first;
  next.stamp_ns += 100'000'000;
  EXPECT_FALSE(closer.AddKeyframe(next).is_new_sequence);
  EXPECT_TRUE(closer.AddKeyframe(first).is_new_sequence) << "the stamp went back";
  EXPECT_TRUE(closer.AddKeyframe(first).is_new_sequence) << "the stamp stood still";
  next.T_W_B.t.x() += 3.9;  // at most 40 m/s
  EXPECT_FALSE(closer.AddKeyframe(next).is_new_sequence);
  next.stamp_ns += 100'000'000;
  next.T_W_B.t.x() += 4.1;
  EXPECT_TRUE(closer.AddKeyframe(next).is_new_sequence);
  EXPECT_EQ(closer.sequence_count(), 4);
  EXPECT_EQ(closer.keyframe_count(), 6);
}

}  // namespace
}  // namespace deja_view
