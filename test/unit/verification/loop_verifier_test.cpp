#include "deja_view/verification/loop_verifier.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"

#include <functional>

#include "keyframe_pair.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using test::KeyframePair;
using test::KeyframePairOptions;
using test::MakeKeyframePair;

Verification Verify(const KeyframePair& pair, const LoopVerifierOptions& options = {}) {
  return LoopVerifier(options, pair.camera)
      .Verify(pair.current.features, pair.current.T_W_B.q, pair.old.features, pair.old.T_W_B.q);
}

void ForgetPoints(KeyframeFeatures* features) {
  features->points_B.clear();
  features->point_pixels.clear();
  features->point_depth_sigmas.clear();
  features->point_ids.clear();
  features->point_descriptors.clear();
}

void ExpectRightPose(const KeyframePair& pair, const Verification& v) {
  ASSERT_EQ(v.reason, RejectReason::kNone)
      << EnumToString(v.reason) << ", " << v.inliers << " inliers";
  EXPECT_LT((v.T_Bold_Bcurrent.t - pair.T_old_current().t).norm(), 0.04);
  EXPECT_LT(RotationAngle(v.T_Bold_Bcurrent.q.conjugate() * pair.T_old_current().q), 0.4 * kDegree);
}

TEST(LoopVerifier, FindsTheRelativePose) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    KeyframePairOptions options;
    options.seed = seed;
    const KeyframePair pair = MakeKeyframePair(options);
    const Verification v = Verify(pair);
    ExpectRightPose(pair, v);
    EXPECT_GT(v.inliers, 150);
    EXPECT_LE(v.inliers, v.guided);
    EXPECT_LE(v.guided, v.visible);
    EXPECT_LT(v.log10_false_alarms, -20);
    EXPECT_NEAR(v.scene_depth, SceneDepth(pair.old.features), 0.2 * v.scene_depth);
    EXPECT_LT(v.rmse_px, 4.0);
    EXPECT_LT(v.gravity_disagreement, 0.5 * kDegree);
  }
}

TEST(LoopVerifier, TellsHowFarItMayErr) {
  double normalised = 0;
  constexpr int kRuns = 20;
  for (int run = 0; run < kRuns; ++run) {
    KeyframePairOptions options;
    options.seed = 100 + static_cast<std::uint64_t>(run);
    const KeyframePair pair = MakeKeyframePair(options);
    const Verification v = Verify(pair);
    const Eigen::Vector3d error = v.T_Bold_Bcurrent.t - pair.T_old_current().t;
    normalised += error.dot(v.covariance.topLeftCorner<3, 3>().ldlt().solve(error)) / 3;
  }
  EXPECT_GT(normalised / kRuns, 0.05);
  EXPECT_LT(normalised / kRuns, 2.0);
}

TEST(LoopVerifier, PointsOfOneKeyframeAreEnough) {
  const KeyframePair both = MakeKeyframePair({});
  KeyframePair forward = both;
  ForgetPoints(&forward.old.features);
  const Verification f = Verify(forward);
  ExpectRightPose(forward, f);
  EXPECT_EQ(static_cast<int>(f.point_matches.size()), f.inliers);
  KeyframePair reverse = both;
  ForgetPoints(&reverse.current.features);
  const Verification r = Verify(reverse);
  ExpectRightPose(reverse, r);
  EXPECT_TRUE(r.point_matches.empty());
  EXPECT_GT(Verify(both).inliers, std::max(f.inliers, r.inliers));
}

TEST(LoopVerifier, PointMatchesNameWhatShowsTheSamePoint) {
  const KeyframePair pair = MakeKeyframePair({});
  const Verification v = Verify(pair);
  ASSERT_GT(v.point_matches.size(), 60U);
  for (const PointMatch& match : v.point_matches) {
    EXPECT_EQ(pair.current.features.point_ids.at(static_cast<std::size_t>(match.point)),
              pair.old.keypoint_ids.at(static_cast<std::size_t>(match.keypoint)));
  }
}

TEST(LoopVerifier, GivesTheSameBitsTwice) {
  const KeyframePair pair = MakeKeyframePair({});
  const Verification a = Verify(pair);
  const Verification b = Verify(pair);
  EXPECT_EQ(a.T_Bold_Bcurrent.t, b.T_Bold_Bcurrent.t);
  EXPECT_EQ(a.T_Bold_Bcurrent.q.coeffs(), b.T_Bold_Bcurrent.q.coeffs());
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.inliers, b.inliers);
}

TEST(LoopVerifier, RejectsAnotherPlace) {
  const KeyframePair here = MakeKeyframePair({});
  KeyframePairOptions options;
  options.seed = 2;
  KeyframePair pair = MakeKeyframePair(options);
  pair.old = here.old;
  EXPECT_EQ(Verify(pair).reason, RejectReason::kTooFewMatches);
}

TEST(LoopVerifier, RejectsMatchesWithoutACommonPose) {
  KeyframePairOptions options;
  options.scatters_pixels = true;
  const Verification v = Verify(MakeKeyframePair(options));
  EXPECT_GT(v.matches, 100);
  EXPECT_EQ(v.reason, RejectReason::kTooFewInliers);
}

TEST(LoopVerifier, RejectsWhenMostVisiblePointsLookDifferent) {
  KeyframePairOptions options;
  options.recognised = 22;
  options.tracked = 150;
  const Verification v = Verify(MakeKeyframePair(options));
  EXPECT_LT(v.inliers, 0.2 * v.visible);
  EXPECT_EQ(v.reason, RejectReason::kLowInlierRatio);
}

TEST(LoopVerifier, RejectsInliersThatCrowd) {
  KeyframePairOptions options;
  options.room = 0.1;
  const Verification v = Verify(MakeKeyframePair(options));
  EXPECT_GE(v.inliers, 25);
  EXPECT_EQ(v.reason, RejectReason::kUncertain) << "what shifts one shifts all";
}

TEST(LoopVerifier, AcceptsFewInliersThatSpread) {
  KeyframePairOptions options;
  options.tracked = 12;
  const KeyframePair pair = MakeKeyframePair(options);
  const Verification v = Verify(pair);
  ExpectRightPose(pair, v);
  EXPECT_LT(v.inliers, 25);
}

/// So few points are alike that no two matches over the whole image agree by more than chance.
TEST(LoopVerifier, APredictedPoseFindsWhatTheWholeImageHides) {
  KeyframePairOptions few;
  few.descriptor_noise = 45;
  LoopVerifierOptions options;
  options.max_distance = 40;  // bits: over the whole image, hardly a right match passes
  options.min_inlier_ratio = 0.1;
  const KeyframePair pair = MakeKeyframePair(few);
  ASSERT_NE(Verify(pair, options).reason, RejectReason::kNone);
  const auto verify = [&](const Rigid3& predicted) {
    return LoopVerifier(options, pair.camera)
        .Verify(pair.current.features,
                pair.current.T_W_B.q,
                pair.old.features,
                pair.old.T_W_B.q,
                predicted);
  };
  Rigid3 near = pair.T_old_current();
  near.t += Eigen::Vector3d(0.05, -0.05, 0.03);
  ExpectRightPose(pair, verify(near));
  near.t += Eigen::Vector3d(0, 2, 0);
  EXPECT_NE(verify(near).reason, RejectReason::kNone);
  options.predicted_radius_px = 0;
  EXPECT_NE(verify(pair.T_old_current()).reason, RejectReason::kNone);
}

TEST(LoopVerifier, RejectsATiltThatTheVioDoesNotShow) {
  const KeyframePair pair = MakeKeyframePair({});
  const Eigen::Quaterniond tilted = ExpSo3({0, 1.2 * kDegree, 0}) * pair.current.T_W_B.q;
  LoopVerifierOptions options;
  options.max_gravity_deg = 0.5;
  const auto v = LoopVerifier(options, pair.camera)
                     .Verify(pair.current.features, tilted, pair.old.features, pair.old.T_W_B.q);
  EXPECT_NEAR(v.gravity_disagreement, 1.2 * kDegree, 0.3 * kDegree);
  EXPECT_EQ(v.reason, RejectReason::kGravity);
  EXPECT_EQ(Verify(pair, options).reason, RejectReason::kNone);
}

struct GateCase {
  const char* name;
  RejectReason reason;
  std::function<void(LoopVerifierOptions*)> tighten;
};

class LoopVerifierGate : public testing::TestWithParam<GateCase> {};

TEST_P(LoopVerifierGate, RejectsWithItsOwnReason) {
  LoopVerifierOptions options;
  GetParam().tighten(&options);
  ASSERT_TRUE(options.Validate().empty());
  const Verification v = Verify(MakeKeyframePair({}), options);
  EXPECT_EQ(v.reason, GetParam().reason) << EnumToString(v.reason);
}

INSTANTIATE_TEST_SUITE_P(
    All,
    LoopVerifierGate,
    testing::Values(GateCase{"Matches",
                             RejectReason::kTooFewMatches,
                             [](LoopVerifierOptions* o) { o->min_matches = 1000; }},
                    GateCase{"RansacInliers",
                             RejectReason::kTooFewInliers,
                             [](LoopVerifierOptions* o) { o->min_ransac_inliers = 1000; }},
                    GateCase{"Chance",
                             RejectReason::kByChance,
                             [](LoopVerifierOptions* o) { o->max_log10_false_alarms = -400; }},
                    GateCase{"Ratio",
                             RejectReason::kLowInlierRatio,
                             [](LoopVerifierOptions* o) { o->min_inlier_ratio = 1.0; }},
                    GateCase{"Far",
                             RejectReason::kTooFar,
                             [](LoopVerifierOptions* o) { o->max_distance_over_depth = 0.05; }},
                    GateCase{"Yaw",
                             RejectReason::kTooMuchYaw,
                             [](LoopVerifierOptions* o) { o->max_yaw_deg = 12.0; }},
                    GateCase{"Uncertain",
                             RejectReason::kUncertain,
                             [](LoopVerifierOptions* o) { o->max_sigma_over_depth = 1e-5; }},
                    GateCase{"UncertainInMetres",
                             RejectReason::kUncertain,
                             [](LoopVerifierOptions* o) { o->max_sigma_m = 1e-4; }}),
    [](const auto& gate) { return std::string(gate.param.name); });

TEST(LoopVerifier, NeedsACameraAndSomethingToCompare) {
  EXPECT_THROW(LoopVerifier({}, nullptr), CheckError);
  KeyframePair pair = MakeKeyframePair({});
  pair.old.features = KeyframeFeatures{};
  EXPECT_EQ(Verify(pair).reason, RejectReason::kTooFewMatches);
  pair.current.features = KeyframeFeatures{};
  EXPECT_EQ(Verify(pair).reason, RejectReason::kTooFewMatches);
}

TEST(LoopVerifierOptions, ListsAllViolations) {
  EXPECT_TRUE(LoopVerifierOptions{}.Validate().empty());
  LoopVerifierOptions options;
  options.max_distance = 257;
  options.max_ratio = 0;
  options.max_log10_false_alarms = 0;
  options.max_sigma_over_depth = 0;
  options.pose.confidence = 1;
  const auto errors = options.Validate();
  ASSERT_EQ(errors.size(), 5U);
  EXPECT_EQ(errors[0], "max_distance: 257, expected 1 to 256");
  EXPECT_EQ(errors[4], "pose.confidence: 1, expected more than 0, less than 1");
}

TEST(KeyframeFeatures, CountsItsMemory) {
  KeyframeFeatures features;
  EXPECT_EQ(features.MemoryBytes(), 0U);
  features.descriptors.resize(100);
  features.points_B.resize(10);
  EXPECT_EQ(features.MemoryBytes(), 100 * 32U + 10 * 12U);
}

}  // namespace
}  // namespace deja_view
