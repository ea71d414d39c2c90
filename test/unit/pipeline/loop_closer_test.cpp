#include "deja_view/pipeline/loop_closer.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/lab/evaluation/ape.hpp"

#include <atomic>
#include <cmath>
#include <limits>
#include <thread>

#include "small_flight.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using test::DefaultOutcome;
using test::FlightOptions;
using test::FlightVocabulary;
using test::Fly;
using test::MakeCloser;
using test::Outcome;
using test::SmallFlight;

void ExpectSameBits(const Outcome& a, const Outcome& b) {
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size());
  for (std::size_t i = 0; i < a.keyframes.size(); ++i) {
    EXPECT_EQ(a.keyframes[i].T_M_B.t, b.keyframes[i].T_M_B.t) << i;
    EXPECT_EQ(a.keyframes[i].T_M_B.q.coeffs(), b.keyframes[i].T_M_B.q.coeffs()) << i;
    EXPECT_EQ(a.reports[i].reason, b.reports[i].reason) << i;
    EXPECT_EQ(a.reports[i].graph_changed, b.reports[i].graph_changed) << i;
  }
  ASSERT_EQ(a.loops.size(), b.loops.size());
  for (std::size_t i = 0; i < a.loops.size(); ++i) {
    EXPECT_EQ(a.loops[i].T_Bold_Bcurrent.t, b.loops[i].T_Bold_Bcurrent.t);
    EXPECT_EQ(a.loops[i].covariance, b.loops[i].covariance);
  }
}

TEST(LoopCloser, FindsLoopsAndAllAreRight) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  const Outcome& outcome = DefaultOutcome();
  ASSERT_GE(outcome.loops.size(), 10U);
  for (const LoopReport& loop : outcome.loops) {
    const auto old = static_cast<std::size_t>(loop.old);
    const auto current = static_cast<std::size_t>(loop.current);
    const Rigid3 truth = flight.T_W_B[old].Inverse() * flight.T_W_B[current];
    EXPECT_LT((loop.T_Bold_Bcurrent.t - truth.t).norm(), 0.3);
    EXPECT_LT(RotationAngle(loop.T_Bold_Bcurrent.q.conjugate() * truth.q), 3 * kDegree);
    EXPECT_EQ(loop.stamp_old_ns, flight.keyframes[old].stamp_ns);
    EXPECT_EQ(loop.stamp_current_ns, flight.keyframes[current].stamp_ns);
    EXPECT_GE(static_cast<double>(loop.stamp_current_ns - loop.stamp_old_ns),
              1e9 * FlightOptions().candidates.min_age_s);
    EXPECT_TRUE(loop.accepted());
  }
}

TEST(LoopCloser, APlaceThatIsKnownWellIsNotVerifiedTwice) {
  LoopCloserOptions options = FlightOptions();
  options.map_spacing_m = 1.0;
  const auto count = [](const Outcome& outcome) {
    int localised = 0;
    std::size_t verified = 0;
    for (const KeyframeReport& report : outcome.reports) {
      localised += report.reason == RejectReason::kNone ? 1 : 0;
      verified += report.loops.size();
    }
    return std::make_pair(localised, verified);
  };
  options.candidates.known_loops = 0;
  const auto [localised, verified] = count(Fly(options));
  options.candidates.known_loops = 1;
  const auto [localised_known, verified_known] = count(Fly(options));
  EXPECT_GT(localised, 10);
  EXPECT_GE(localised_known, localised - 1);
  EXPECT_LT(verified_known, verified);
}

TEST(LoopCloser, LoopsTakeTheDriftAway) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  std::vector<Eigen::Vector3d> truth;
  std::vector<Eigen::Vector3d> vio;
  std::vector<Eigen::Vector3d> corrected;
  for (const KeyframeInfo& keyframe : DefaultOutcome().keyframes) {
    truth.push_back(flight.T_W_B[static_cast<std::size_t>(keyframe.index)].t);
    vio.push_back(keyframe.T_W_B.t);
    corrected.push_back(keyframe.T_M_B.t);
  }
  EXPECT_LT(ComputeApe(truth, corrected).rmse, 0.7 * ComputeApe(truth, vio).rmse);
}

TEST(LoopCloser, ReportsWhatItDid) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  const Outcome& outcome = DefaultOutcome();
  int accepted = 0;
  int withdrawn = static_cast<int>(outcome.withdrawn.size());
  bool changed = false;
  int relocalisations = 0;
  for (std::size_t i = 0; i < outcome.reports.size(); ++i) {
    const KeyframeReport& report = outcome.reports[i];
    EXPECT_EQ(report.index, static_cast<int>(i));
    EXPECT_EQ(report.is_new_sequence, i == 0);
    for (const LoopReport& loop : report.loops) {
      accepted += loop.accepted() ? 1 : 0;
      withdrawn += loop.reason == RejectReason::kWithdrawn ? 1 : 0;
    }
    changed = changed || report.graph_changed;
    if (!report.relocalisation) {
      continue;
    }
    ++relocalisations;
    const Relocalisation& r = *report.relocalisation;
    // Tracked points of this keyframe, where the old camera really sees them.
    const Rigid3 T_Cold_W =
        (flight.T_W_B[static_cast<std::size_t>(r.old)] * flight.T_B_C).Inverse();
    int near = 0;
    for (const RelocalisationPoint& point : r.points) {
      for (const TrackedPoint& tracked : flight.keyframes[i].points) {
        if (tracked.feature_id == point.feature_id) {
          const Rigid3 T_W_V = flight.T_W_B[i] * flight.keyframes[i].T_W_B.Inverse();
          const Eigen::Vector3d p = T_Cold_W * (T_W_V * tracked.p_W);
          near += (p.hnormalized() - point.normalised_old).norm() < 0.08 ? 1 : 0;
        }
      }
    }
    EXPECT_GE(near, 0.8 * static_cast<double>(r.points.size()));
  }
  EXPECT_EQ(accepted - withdrawn, static_cast<int>(outcome.loops.size()));
  EXPECT_LT(withdrawn, accepted / 10);
  EXPECT_TRUE(changed);
  EXPECT_GT(relocalisations, 3);
}

TEST(LoopCloser, GivesTheSameBitsTwice) {
  ExpectSameBits(Fly(FlightOptions()), DefaultOutcome());
}

TEST(LoopCloser, SolvingInAnotherThreadGivesTheSameBits) {
  std::atomic<int> solves{0};
  const auto outcome = Fly(FlightOptions(), [&](std::function<void()> solve) {
    ++solves;
    return std::async(std::launch::async, std::move(solve));
  });
  EXPECT_GT(solves, 0);
  ExpectSameBits(outcome, DefaultOutcome());
}

TEST(LoopCloser, WaitsForItsSolverBeforeItEnds) {
  std::atomic<bool> is_done{false};
  std::atomic<int> solves{0};
  {
    const sim::RecordedFlight& flight = SmallFlight(1);
    LoopCloserOptions options = FlightOptions();
    options.solve.latency = 1000;
    LoopCloser closer(options,
                      flight.camera,
                      flight.T_B_C,
                      FlightVocabulary(),
                      [&](const std::function<void()>& solve) {
                        ++solves;
                        return std::async(std::launch::async, [&is_done, solve] {
                          std::this_thread::sleep_for(std::chrono::milliseconds(50));
                          solve();
                          is_done = true;
                        });
                      });
    for (const KeyframeInput& keyframe : flight.keyframes) {
      closer.AddKeyframe(keyframe);
      if (solves > 0) {
        break;
      }
    }
  }
  EXPECT_EQ(solves, 1);
  EXPECT_TRUE(is_done);
}

TEST(LoopCloser, BadKeyframesAreRefusedAndLeaveNoTrace) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  LoopCloser closer = MakeCloser(1);
  const auto add_bad = [&](const KeyframeInput& good) {
    KeyframeInput bad = good;
    bad.image = cv::Mat(good.image.rows, good.image.cols - 1, CV_8UC1, cv::Scalar(0));
    EXPECT_THROW(closer.AddKeyframe(bad), InputError);
    bad.image = cv::Mat(good.image.rows, good.image.cols, CV_8UC3, cv::Scalar(0));
    EXPECT_THROW(closer.AddKeyframe(bad), InputError);
    bad.image = cv::Mat();
    EXPECT_THROW(closer.AddKeyframe(bad), InputError);
    bad = good;
    bad.T_W_B.t.y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(closer.AddKeyframe(bad), InputError);
    bad = good;
    bad.T_W_B.q.coeffs() *= 1.1;
    EXPECT_THROW(closer.AddKeyframe(bad), InputError);
  };
  for (std::size_t i = 0; i < flight.keyframes.size(); ++i) {
    add_bad(flight.keyframes[i]);
    EXPECT_EQ(closer.keyframe_count(), static_cast<int>(i));
    closer.AddKeyframe(flight.keyframes[i]);
  }
  closer.OptimizeFully();
  ASSERT_EQ(closer.accepted_loops().size(), DefaultOutcome().loops.size());
  for (int i = 0; i < closer.keyframe_count(); ++i) {
    EXPECT_EQ(closer.keyframe(i).T_M_B.t,
              DefaultOutcome().keyframes[static_cast<std::size_t>(i)].T_M_B.t);
  }
}

TEST(LoopCloser, LeavesOutPointsThatAreNotFinite) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  LoopCloser closer = MakeCloser(1);
  for (KeyframeInput keyframe : flight.keyframes) {
    TrackedPoint point;
    point.p_W = {nan, 1, 2};
    point.pixel = {50, 50};
    keyframe.points.insert(keyframe.points.begin(), point);
    point.p_W = {1, std::numeric_limits<double>::infinity(), 2};
    keyframe.points.push_back(point);
    point.p_W = {3, 2, 1};
    point.pixel = {50, static_cast<float>(nan)};
    keyframe.points.push_back(point);
    closer.AddKeyframe(keyframe);
  }
  closer.OptimizeFully();
  EXPECT_EQ(closer.keyframe(closer.keyframe_count() - 1).T_M_B.t,
            DefaultOutcome().keyframes.back().T_M_B.t);
}

TEST(LoopCloser, AKeyframeWithoutPointsIsStillAPlace) {
  LoopCloser closer = MakeCloser(1);
  KeyframeInput keyframe = SmallFlight(1).keyframes.front();
  keyframe.points.clear();
  const KeyframeReport report = closer.AddKeyframe(keyframe);
  EXPECT_EQ(report.reason, RejectReason::kNoCandidate);
  EXPECT_EQ(closer.place_count(), 1);
  EXPECT_GT(closer.memory_bytes(), 10000U);
}

TEST(LoopCloser, MapSpacingThinsThePlaces) {
  LoopCloserOptions options = FlightOptions();
  options.map_spacing_m = 0.6;
  options.map_spacing_deg = 40;
  const Outcome thin = Fly(options);
  EXPECT_EQ(DefaultOutcome().places, static_cast<int>(DefaultOutcome().keyframes.size()));
  EXPECT_LT(thin.places, 0.8 * DefaultOutcome().places);
  EXPECT_GT(thin.places, 5);
  EXPECT_EQ(thin.keyframes.size(), DefaultOutcome().keyframes.size());
}

/// Flies until a keyframe has several loops and a relocalisation against one of them.
std::optional<Relocalisation> FlyUntilRelocalised(LoopCloser* closer, int* current) {
  for (const KeyframeInput& keyframe : SmallFlight(1).keyframes) {
    const KeyframeReport report = closer->AddKeyframe(keyframe);
    int loops = 0;
    for (const LoopReport& loop : report.loops) {
      loops += loop.accepted() && loop.current == report.index ? 1 : 0;
    }
    if (report.relocalisation && loops > 1) {
      *current = report.index;
      return report.relocalisation;
    }
  }
  return std::nullopt;
}

TEST(LoopCloser, TakesTheVioMeasurementOfALoopWhenItIsNear) {
  LoopCloser closer = MakeCloser(1);
  int current = 0;
  const auto relocalisation = FlyUntilRelocalised(&closer, &current);
  ASSERT_TRUE(relocalisation);
  const auto pose = [&] {
    for (const LoopReport& loop : closer.accepted_loops()) {
      if (loop.current == current && loop.old == relocalisation->old) {
        return loop.T_Bold_Bcurrent;
      }
    }
    return Rigid3{};
  };
  const Rigid3 before = pose();
  Rigid3 near = before;
  near.t.x() += 0.05;
  Rigid3 far = before;
  far.t.x() += 0.6;
  const Rigid3 turned{FromYaw(0.6) * before.q, before.t};
  Rigid3 broken = before;
  broken.t.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(closer.UpdateLoop(current, far));
  EXPECT_FALSE(closer.UpdateLoop(current, turned));
  EXPECT_FALSE(closer.UpdateLoop(current, broken));
  EXPECT_FALSE(closer.UpdateLoop(0, near)) << "has no loop";
  EXPECT_FALSE(closer.UpdateLoop(100000, near));
  EXPECT_FALSE(closer.UpdateLoop(-1, near));
  EXPECT_EQ(pose().t, before.t);
  EXPECT_TRUE(closer.UpdateLoop(current, near));
  closer.OptimizeFully();
  EXPECT_EQ(pose().t, near.t) << "the loop that the VIO was told of, and no other";
}

/// Flies to the end with the VIO's measurement of a loop, half a metre off, that comes `late`
/// keyframes after the loop's; the drift after each keyframe from the loop's on.
std::vector<Eigen::Vector3d> DriftsWithMeasurement(int late) {
  LoopCloser closer = MakeCloser(1);
  int current = 0;
  const auto relocalisation = FlyUntilRelocalised(&closer, &current);
  EXPECT_TRUE(relocalisation);
  std::vector<Eigen::Vector3d> drifts;
  const auto& keyframes = SmallFlight(1).keyframes;
  for (int i = current; i < static_cast<int>(keyframes.size()); ++i) {
    if (i > current) {
      closer.AddKeyframe(keyframes[static_cast<std::size_t>(i)]);
    }
    for (const LoopReport& loop : closer.accepted_loops()) {
      if (i == current + late && loop.current == current && loop.old == relocalisation->old) {
        Rigid3 measured = loop.T_Bold_Bcurrent;
        measured.t.x() += 0.4;
        EXPECT_TRUE(closer.UpdateLoop(current, measured));
      }
    }
    drifts.push_back(closer.drift().t);
  }
  closer.OptimizeFully();
  drifts.push_back(closer.drift().t);
  return drifts;
}

TEST(LoopCloser, ItMattersNotBetweenWhichKeyframesTheVioMeasures) {
  const int latency = FlightOptions().solve.measurement_latency;
  const auto at_once = DriftsWithMeasurement(0);
  ASSERT_GT(static_cast<int>(at_once.size()), latency + 2) << "else there is nothing to see";
  EXPECT_EQ(at_once, DriftsWithMeasurement(1));
  EXPECT_EQ(at_once, DriftsWithMeasurement(latency - 1));
  EXPECT_NE(at_once, DriftsWithMeasurement(static_cast<int>(at_once.size())));
}

TEST(LoopCloser, UsesANewExtrinsicFromTheNextKeyframeOn) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  // No tracked point fits its pixel with a camera that is turned by ten degrees.
  const Rigid3 wrong{flight.T_B_C.q * ExpSo3({0, 10 * kDegree, 0}), flight.T_B_C.t};
  const auto count_loops = [&](bool corrects) {
    LoopCloserOptions options = FlightOptions();
    options.motion_stereo.recent = 0;  // corners of our own fit any extrinsic
    LoopCloser closer(options, flight.camera, wrong, FlightVocabulary());
    closer.AddKeyframe(flight.keyframes[0]);
    if (corrects) {
      closer.SetExtrinsic(flight.T_B_C);
    }
    for (std::size_t i = 1; i < flight.keyframes.size(); ++i) {
      closer.AddKeyframe(flight.keyframes[i]);
    }
    return closer.accepted_loops().size();
  };
  EXPECT_EQ(count_loops(false), 0U);
  EXPECT_GE(count_loops(true), 10U);
}

TEST(LoopCloser, NamesInvalidOptionsAndAWrongVocabulary) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  LoopCloserOptions options;
  options.candidates.min_age_s = 0;
  options.solve.every_loops = 0;
  options.verification.min_matches = 0;
  try {
    LoopCloser(options, flight.camera, flight.T_B_C, FlightVocabulary());
    FAIL() << "no exception";
  } catch (const InputError& e) {
    const std::string what = e.what();
    for (const char* key :
         {"candidates.min_age_s", "solve.every_loops", "verification.min_matches"}) {
      EXPECT_NE(what.find(key), std::string::npos) << what;
    }
  }
  options = {};
  options.features.kind = FeatureKind::kOrb;
  EXPECT_THROW(LoopCloser(options, flight.camera, flight.T_B_C, FlightVocabulary()), InputError);
}

TEST(LoopCloser, ChecksIndices) {
  const LoopCloser closer = MakeCloser(1);
  EXPECT_THROW(closer.keyframe(0), CheckError);
  EXPECT_THROW(closer.keyframe(-1), CheckError);
  EXPECT_EQ(closer.sequence_count(), 0);
  EXPECT_EQ(closer.drift().t, Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace deja_view
