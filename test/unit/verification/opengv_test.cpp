// Our rig pose beside OpenGV's generalised pose, two implementations that share nothing.
#include "deja_view/base/angles.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include "rig_pose_scene.hpp"
#include <gtest/gtest.h>

#ifdef DEJA_VIEW_HAS_OPENGV
#include "opengv_rig_pose.hpp"

namespace deja_view {
namespace {

using test::kRigFocalPx;
using test::MakeRigPoseScene;
using test::OpengvRigPose;
using test::RigPoseScene;
using test::RigPoseSceneOptions;

bool IsNear(const Rigid3& a, const Rigid3& b, double metres, double radians) {
  return (a.t - b.t).norm() < metres && RotationAngle(a.q.conjugate() * b.q) < radians;
}

RigPoseSceneOptions Exact() {
  RigPoseSceneOptions options;
  options.pixel_noise = options.depth_noise = options.tilt_noise_deg = options.outlier_ratio = 0;
  return options;
}

// One of the two-point solver's solutions is one of GP3P's: both hold the true pose.
TEST(OpengvRigPose, MinimalSolversAgreeWithoutNoise) {
  int both = 0;
  for (std::uint32_t seed = 1; seed <= 50; ++seed) {
    RigPoseSceneOptions options = Exact();
    options.seed = seed;
    options.radius_m = 0.5;
    const RigPoseScene scene = MakeRigPoseScene(options);
    const Rigid3 T_G_O{scene.gravity.q_G_O, Eigen::Vector3d::Zero()};
    const Rigid3 T_G_U{scene.gravity.q_G_U, Eigen::Vector3d::Zero()};
    const auto level = [&](const PointObservation& o) {
      return GravityAlignedPoint{T_G_U * o.point, T_G_O * o.bearing, T_G_O * o.centre};
    };
    const std::vector<Rigid3> theirs = OpengvRigPose(scene.observations).Minimal({0, 1, 2});
    for (const YawTransform& yaw :
         SolveTwoPointGravityPose(level(scene.observations[0]), level(scene.observations[1]))) {
      const Rigid3 ours = T_G_O.Inverse() * yaw.ToRigid3() * T_G_U;
      for (const Rigid3& other : theirs) {
        if (IsNear(ours, other, 1e-4, 1e-4)) {
          EXPECT_TRUE(IsNear(ours, scene.T_O_U, 1e-4, 1e-4));
          ++both;
        }
      }
    }
  }
  EXPECT_GE(both, 45) << "a few triples are degenerate for one of the two";
}

TEST(OpengvRigPose, RefinementsAgreeWithoutNoise) {
  const RigPoseScene scene = MakeRigPoseScene(Exact());
  std::vector<int> all(scene.observations.size());
  std::iota(all.begin(), all.end(), 0);
  const Rigid3 start{ExpSo3({0.01, -0.02, 0.02}) * scene.T_O_U.q,
                     scene.T_O_U.t + Eigen::Vector3d(0.05, -0.03, 0.04)};
  const Rigid3 ours =
      RefineRelativePose(start, scene.observations, scene.gravity, false, kRigFocalPx, {}).T_O_U;
  const Rigid3 theirs = OpengvRigPose(scene.observations).Refine(start, all);
  EXPECT_TRUE(IsNear(ours, theirs, 1e-4, 1e-4));
}

struct Errors {
  std::vector<double> metres;  ///< of the hypothesis
  int solved = 0;              ///< after refinement, within 10 cm and 1 degree
};

TEST(OpengvRigPose, RobustPosesAgreeInNoise) {
  Errors ours;
  Errors theirs;
  constexpr int kScenes = 60;
  for (std::uint32_t seed = 1; seed <= kScenes; ++seed) {
    RigPoseSceneOptions options;
    options.cameras = 2 + static_cast<int>(seed % 4);
    options.radius_m = seed % 2 == 0 ? 0.02 : 0.6;
    options.outlier_ratio = 0.2 + 0.1 * (seed % 5);
    options.seed = seed;
    const RigPoseScene scene = MakeRigPoseScene(options);
    const auto add = [&](const RansacResult& ransac, Errors* errors) {
      errors->metres.push_back((ransac.T_O_U.t - scene.T_O_U.t).norm());
      const Rigid3 refined =
          RefineRelativePose(ransac.T_O_U, scene.observations, scene.gravity, true, kRigFocalPx, {})
              .T_O_U;
      errors->solved += IsNear(refined, scene.T_O_U, 0.1, 1.0 * kDegree);
    };
    add(EstimateRelativePose(scene.observations, scene.gravity, kRigFocalPx, {}), &ours);
    add(OpengvRigPose(scene.observations).Ransac(kRigFocalPx, {}, 1000), &theirs);
  }
  EXPECT_GE(ours.solved, kScenes - 1);
  EXPECT_GE(theirs.solved, kScenes - 1);
  const auto median = [](std::vector<double>* values) {
    std::sort(values->begin(), values->end());
    return (*values)[values->size() / 2];
  };
  EXPECT_LT(median(&ours.metres), 0.8 * median(&theirs.metres)) << "why ours is used";
}

}  // namespace
}  // namespace deja_view

#else

TEST(OpengvRigPose, IsComparedWhereInstalled) {
  GTEST_SKIP() << "built without OpenGV";
}

#endif
