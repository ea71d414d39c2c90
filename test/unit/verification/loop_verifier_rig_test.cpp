#include "deja_view/base/angles.hpp"
#include "deja_view/verification/loop_verifier.hpp"

#include "keyframe_pair.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using test::KeyframePair;
using test::KeyframePairOptions;
using test::MakeKeyframePair;

/// An old keyframe that turned its back on the room: its own image and points show nothing of it,
/// but the virtual camera, half a metre and 40 degrees away, sees what `pair.old` sees.
struct RigScene {
  KeyframePair pair;
  Rigid3 T_W_Bold;
  KeyframeFeatures old;
  RigCamera view;

  Rigid3 T_old_current() const { return T_W_Bold.Inverse() * pair.current.T_W_B; }
};

RigScene MakeRigScene(const KeyframePairOptions& options = {}) {
  RigScene scene;
  scene.pair = MakeKeyframePair(options);
  const Rigid3 T_Bold_B{FromYaw(0.7), {0.3, -0.4, 0.1}};  // from the body of pair.old
  scene.T_W_Bold = scene.pair.old.T_W_B * T_Bold_B.Inverse();
  scene.view.camera = scene.pair.camera;
  KeyframeFeatures& f = scene.view.features;
  f = scene.pair.old.features;
  f.T_B_C = T_Bold_B * f.T_B_C;
  for (Eigen::Vector3f& p : f.points_B) {
    p = (T_Bold_B * p.cast<double>()).cast<float>();
  }
  KeyframePairOptions elsewhere = options;
  elsewhere.seed += 1000;
  scene.old = MakeKeyframePair(elsewhere).old.features;
  return scene;
}

Verification VerifyRig(const RigScene& scene,
                       const std::vector<RigCamera>& cameras,
                       const LoopVerifierOptions& options = {}) {
  return LoopVerifier(options, scene.pair.camera)
      .VerifyRig(scene.pair.current.features,
                 scene.pair.current.T_W_B.q,
                 scene.old,
                 scene.T_W_Bold.q,
                 cameras);
}

TEST(LoopVerifierRig, AVirtualCameraAloneGivesThePose) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    KeyframePairOptions options;
    options.seed = seed;
    const RigScene scene = MakeRigScene(options);
    EXPECT_NE(VerifyRig(scene, {}).reason, RejectReason::kNone) << "the real image must not do";
    const Verification v = VerifyRig(scene, {scene.view});
    ASSERT_EQ(v.reason, RejectReason::kNone) << EnumToString(v.reason);
    const Rigid3 truth = scene.T_old_current();
    EXPECT_LT((v.T_Bold_Bcurrent.t - truth.t).norm(), 0.06);
    EXPECT_LT(RotationAngle(v.T_Bold_Bcurrent.q.conjugate() * truth.q), 0.5 * kDegree);
    EXPECT_TRUE(v.point_matches.empty()) << "those are of the real image";
    EXPECT_LE(v.found, v.visible);
  }
}

TEST(LoopVerifierRig, PointsOfUnknownDepthAreNotNeeded) {
  RigScene scene = MakeRigScene();
  KeyframeFeatures& f = scene.view.features;
  f.points_B.clear();
  f.point_pixels.clear();
  f.point_depth_sigmas.clear();
  f.point_ids.clear();
  f.point_descriptors.clear();
  const Verification v = VerifyRig(scene, {scene.view});
  EXPECT_EQ(v.reason, RejectReason::kNone) << EnumToString(v.reason);
  EXPECT_EQ(v.inliers, v.found);
}

TEST(LoopVerifierRig, CountsOnceWhatSeveralCamerasShow) {
  const RigScene scene = MakeRigScene();
  const Verification one = VerifyRig(scene, {scene.view});
  const Verification three = VerifyRig(scene, {scene.view, scene.view, scene.view});
  EXPECT_NEAR(three.inliers, one.inliers, 0.05 * one.inliers);
  EXPECT_NEAR(three.visible, one.visible, 3);
  // Nor is the pose more certain for that.
  EXPECT_GT(three.covariance.trace(), 0.7 * one.covariance.trace());
}

TEST(LoopVerifierRig, WithoutCamerasIsPlainVerification) {
  const KeyframePair pair = MakeKeyframePair({});
  const LoopVerifier verifier({}, pair.camera);
  const Verification a = verifier.Verify(
      pair.current.features, pair.current.T_W_B.q, pair.old.features, pair.old.T_W_B.q);
  const Verification b = verifier.VerifyRig(
      pair.current.features, pair.current.T_W_B.q, pair.old.features, pair.old.T_W_B.q, {});
  EXPECT_EQ(a.T_Bold_Bcurrent.t, b.T_Bold_Bcurrent.t);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.inliers, b.inliers);
}

TEST(LoopVerifierRig, HasGatesOfItsOwn) {
  const RigScene scene = MakeRigScene();
  const Verification v = VerifyRig(scene, {scene.view});
  LoopVerifierOptions options;
  options.max_log10_false_alarms = -400;  // not the rig's
  EXPECT_EQ(VerifyRig(scene, {scene.view}, options).reason, RejectReason::kNone);
  options.rig.max_log10_false_alarms = v.log10_false_alarms - 0.1;
  EXPECT_EQ(VerifyRig(scene, {scene.view}, options).reason, RejectReason::kByChance);
  options = {};
  options.rig.min_inlier_ratio = 1.0;
  EXPECT_EQ(VerifyRig(scene, {scene.view}, options).reason, RejectReason::kLowInlierRatio);
  options = {};
  options.rig.max_gravity_deg = 1e-6;
  EXPECT_EQ(VerifyRig(scene, {scene.view}, options).reason, RejectReason::kGravity);
  options = {};
  options.rig.max_sigma_over_depth = 1e-6;
  EXPECT_EQ(VerifyRig(scene, {scene.view}, options).reason, RejectReason::kUncertain);
  options = {};
  options.rig.min_ransac_ratio = (v.ransac_inliers + 1.0) / v.matches;
  EXPECT_EQ(VerifyRig(scene, {scene.view}, options).reason, RejectReason::kTooFewInliers);
  options.rig = {2.0, 0, 2.0, 0, 0};
  EXPECT_EQ(options.Validate().size(), 5U);
}

TEST(LoopVerifierRig, RejectsViewsOfAnotherPlace) {
  RigScene scene = MakeRigScene();
  KeyframePairOptions elsewhere;
  elsewhere.seed = 77;
  scene.view.features = MakeKeyframePair(elsewhere).old.features;
  EXPECT_NE(VerifyRig(scene, {scene.view, scene.view}).reason, RejectReason::kNone);
}

TEST(LoopVerifierRig, TellsWhetherAViewAgreesWithItsSource) {
  const KeyframePair pair = MakeKeyframePair({});
  const LoopVerifier verifier({}, pair.camera);
  RigCamera view{pair.current.features, pair.camera};
  // The current keyframe's image as a view of the old one, at its true pose in the old body...
  const Rigid3 T = pair.T_old_current();
  view.features.T_B_C = T * view.features.T_B_C;
  for (Eigen::Vector3f& p : view.features.points_B) {
    p = (T * p.cast<double>()).cast<float>();
  }
  const Agreement right = verifier.Agree(view, pair.old.features);
  EXPECT_GT(right.visible, 100);
  EXPECT_GT(right.found, 0.8 * right.visible);
  // ...and a metre off.
  view.features.T_B_C.t.z() += 1.0;
  for (Eigen::Vector3f& p : view.features.points_B) {
    p.z() += 1.0F;
  }
  const Agreement wrong = verifier.Agree(view, pair.old.features);
  EXPECT_LT(wrong.found, 0.1 * wrong.visible);
}

}  // namespace
}  // namespace deja_view
