#include "deja_view/bundle/bundle_adjuster.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/camera/camera_parameters.hpp"

#include <algorithm>
#include <set>

#include "bundle_scene.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

using test::BundleScene;
using test::BundleSceneOptions;
using test::MakeBundleScene;
using test::SceneOf;
using ::testing::HasSubstr;
using Motion = BundleSceneOptions::Motion;

BundleOptions Options() {
  BundleOptions options;
  options.max_view_deg = 60;
  options.threads = 1;
  return options;
}

void ExpectUntouched(const BundleScene& scene) {
  EXPECT_TRUE(scene.problem.points.empty());
  for (std::size_t i = 0; i < scene.T_vio.size(); ++i) {
    EXPECT_EQ(scene.problem.images[i].T_W_B.t, scene.T_vio[i].t);
    EXPECT_EQ(scene.problem.images[i].T_W_B.q.coeffs(), scene.T_vio[i].q.coeffs());
  }
}

TEST(AdjustBundle, TakesTheDriftOutOfAFlight) {
  BundleScene scene = MakeBundleScene();
  scene.AddOdometryPriors();
  const double before = scene.Rmse();
  ASSERT_GT(before, 0.01);
  const BundleSummary summary = AdjustBundle(Options(), &scene.problem);
  ASSERT_TRUE(summary.is_usable()) << summary.obstacle;
  EXPECT_LT(scene.Rmse(), 0.004) << "from " << before << "\n" << summary.ToString();
  EXPECT_LT(summary.rms_px, 0.6);
  EXPECT_GT(summary.points, 400);
  EXPECT_EQ(summary.weak_images, 0);
  // The points are where they are: nothing moves the whole.
  double largest = 0;
  for (const BundlePoint& point : scene.problem.points) {
    const BundleObservation& o = point.observations.front();
    const int truth = scene.point_of_keypoint[static_cast<std::size_t>(o.image)]
                                             [static_cast<std::size_t>(o.keypoint)];
    const double error = (point.p_W - scene.points[static_cast<std::size_t>(truth)]).norm();
    largest = std::max(largest, point.observations.size() > 5 ? error : 0.0);
  }
  EXPECT_LT(largest, 0.1);
}

TEST(AdjustBundle, GivesTheSameBitsOnAnyNumberOfThreads) {
  std::vector<BundleScene> scenes;
  for (const int threads : {1, 3}) {
    BundleScene scene = MakeBundleScene(SceneOf(30, 400));
    scene.AddOdometryPriors();
    BundleOptions options = Options();
    options.threads = threads;
    options.refine.intrinsics = true;
    ASSERT_TRUE(AdjustBundle(options, &scene.problem).is_usable());
    scenes.push_back(std::move(scene));
  }
  for (std::size_t i = 0; i < scenes[0].problem.images.size(); ++i) {
    EXPECT_EQ(scenes[0].problem.images[i].T_W_B.t, scenes[1].problem.images[i].T_W_B.t);
    EXPECT_EQ(scenes[0].problem.images[i].T_W_B.q.coeffs(),
              scenes[1].problem.images[i].T_W_B.q.coeffs());
  }
  ASSERT_EQ(scenes[0].problem.points.size(), scenes[1].problem.points.size());
  for (std::size_t i = 0; i < scenes[0].problem.points.size(); ++i) {
    EXPECT_EQ(scenes[0].problem.points[i].p_W, scenes[1].problem.points[i].p_W);
  }
}

TEST(AdjustBundle, TellsHowFarItIs) {
  BundleScene scene = MakeBundleScene(SceneOf(30, 400));
  scene.AddOdometryPriors();
  std::vector<double> shares;
  ASSERT_TRUE(AdjustBundle(Options(), &scene.problem, {}, [&](double share) {
                shares.push_back(share);
                return true;
              }).is_usable());
  ASSERT_GT(shares.size(), 8U);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_GE(shares.front(), 0);
  EXPECT_GT(shares.back(), 0.8);
  EXPECT_LE(shares.back(), 1);
}

TEST(AdjustBundle, LeavesWhatTheFinishedRoundsGaveWhenItIsStopped) {
  BundleScene scene = MakeBundleScene();
  scene.AddOdometryPriors();
  BundleOptions options = Options();
  BundleScene one_round = scene;
  int rounds = 0;
  const BundleSummary summary = AdjustBundle(
      options,
      &scene.problem,
      [&](const BundleRound&) {
        ++rounds;
        one_round = scene;
      },
      [&](double) { return rounds == 0; });
  ASSERT_TRUE(summary.is_usable()) << summary.obstacle;
  EXPECT_TRUE(summary.was_stopped);
  EXPECT_EQ(summary.rounds.size(), 1U);
  EXPECT_GT(summary.points, 400);
  for (std::size_t i = 0; i < scene.T_vio.size(); ++i) {
    EXPECT_EQ(scene.problem.images[i].T_W_B.t, one_round.problem.images[i].T_W_B.t);
  }
}

TEST(AdjustBundle, LeavesTheProblemAsItWasWhenItIsStoppedAtOnce) {
  for (const double limit : {-1.0, 0.15, 0.25}) {  // before matching, after it, in the solver
    BundleScene scene = MakeBundleScene(SceneOf(30, 400));
    scene.AddOdometryPriors();
    const BundleSummary summary =
        AdjustBundle(Options(), &scene.problem, {}, [&](double share) { return share < limit; });
    EXPECT_THAT(summary.obstacle, HasSubstr("stopped"));
    EXPECT_TRUE(summary.was_stopped);
    EXPECT_TRUE(summary.rounds.empty());
    ExpectUntouched(scene);
  }
}

TEST(AdjustBundle, LearnsTheLens) {
  BundleSceneOptions scene_options;
  scene_options.yaw_noise_deg = 0.03;
  BundleScene scene = MakeBundleScene(scene_options);
  PinholeParameters lens = test::BundleLens();
  lens.fx *= 1.01;
  lens.fy *= 1.01;
  lens.cx += 3;
  lens.k1 = -0.09;
  scene.problem.cameras[0].camera = std::make_shared<PinholeCamera>(lens);
  scene.AddPosePriors();
  BundleOptions options = Options();
  options.refine.intrinsics = true;
  options.refine.distortion = true;
  const BundleSummary summary = AdjustBundle(options, &scene.problem);
  ASSERT_TRUE(summary.is_usable()) << summary.obstacle;
  const CameraParameters found = DescribeCamera(*scene.problem.cameras[0].camera);
  const PinholeParameters truth = test::BundleLens();
  EXPECT_NEAR(found.projection[0], truth.fx, 0.002 * truth.fx);
  EXPECT_NEAR(found.projection[1], truth.fy, 0.002 * truth.fy);
  EXPECT_NEAR(found.projection[2], truth.cx, 1);
  EXPECT_NEAR(found.distortion[0], truth.k1, 0.005);
  EXPECT_LT(summary.rms_px, 0.6);
}

TEST(AdjustBundle, LearnsWhenTheImagesAreTaken) {
  BundleSceneOptions scene_options;
  scene_options.images = 120;  // velocities are those of chords, which are short on a coarse path
  scene_options.time_offset_s = 0.02;
  scene_options.step_noise_m = 0;
  scene_options.yaw_noise_deg = 0;
  BundleScene scene = MakeBundleScene(scene_options);
  SetVelocities(std::vector<int>(scene.T_vio.size(), 0), &scene.problem);
  BundlePriorOptions priors;
  priors.pose_m = 0.005;
  priors.pose_deg = 0.2;
  scene.AddPosePriors(priors);
  BundleOptions options = Options();
  options.refine.time_offset = true;
  options.camera_sigmas.time_offset_s = 0.05;
  const BundleSummary summary = AdjustBundle(options, &scene.problem);
  ASSERT_TRUE(summary.is_usable()) << summary.obstacle;
  EXPECT_NEAR(scene.problem.cameras[0].time_offset_s, 0.02, 0.002);
}

TEST(AdjustBundle, UsesTracksThatJump) {
  BundleSceneOptions scene_options;
  scene_options.has_tracks = true;
  BundleScene scene = MakeBundleScene(scene_options);
  for (BundleImage& image : scene.problem.images) {
    // From the middle of the flight on, tracks are those of other corners.
    for (std::int64_t& id : image.track_ids) {
      const bool is_late = image.stamp_ns > 12'000'000'000;
      id = id < 0 ? -1 : is_late ? (id + 3 * 7) % 900 : id;
    }
  }
  scene.AddOdometryPriors();
  ASSERT_TRUE(AdjustBundle(Options(), &scene.problem).is_usable());
  EXPECT_LT(scene.Rmse(), 0.006);
}

TEST(AdjustBundle, DoesNotFollowAnOdometryThatJumps) {
  BundleScene scene = MakeBundleScene();
  scene.AddOdometryPriors();
  scene.problem.images[0].T_W_B.t += Eigen::Vector3d(0.1, 0.1, 0);  // as before a VIO has settled
  scene.problem.relative_priors[0].T_from_to.t -= Eigen::Vector3d(0.1, 0.1, 0);
  const BundleSummary summary = AdjustBundle(Options(), &scene.problem);
  ASSERT_TRUE(summary.is_usable()) << summary.obstacle;
  EXPECT_LT(scene.Rmse(), 0.004);
}

TEST(AdjustBundle, LeavesAnImageWithoutCornersToItsPriors) {
  BundleScene scene = MakeBundleScene();
  BundleImage& blind = scene.problem.images[30];
  blind.keypoints.clear();
  blind.descriptors.clear();
  blind.track_ids.clear();
  scene.AddOdometryPriors();
  const BundleSummary summary = AdjustBundle(Options(), &scene.problem);
  ASSERT_TRUE(summary.is_usable()) << summary.obstacle;
  EXPECT_EQ(summary.weak_images, 1);
  EXPECT_LT(scene.Rmse(), 0.006);
  const auto covariances = PoseCovariances(Options(), scene.problem, {30, 31});
  const auto variance = [&](std::size_t i) { return covariances[i].topLeftCorner<3, 3>().trace(); };
  // Less what the first image, which is held, leaves open for all.
  EXPECT_GT(variance(0), 2 * variance(1));
}

TEST(AdjustBundle, RefusesADroneThatStandsOrOnlyTurns) {
  for (const Motion motion : {Motion::kStand, Motion::kTurn}) {
    BundleSceneOptions scene_options = SceneOf(30, 900);
    scene_options.motion = motion;
    scene_options.step_noise_m = 0.0005;
    BundleScene scene = MakeBundleScene(scene_options);
    scene.AddOdometryPriors();
    const BundleSummary summary = AdjustBundle(Options(), &scene.problem);
    EXPECT_THAT(summary.obstacle, HasSubstr("parallax"));
    EXPECT_THAT(summary.ToString(), HasSubstr("not adjusted"));
    ExpectUntouched(scene);
  }
}

TEST(AdjustBundle, RefusesTooFewPoints) {
  BundleScene scene = MakeBundleScene(SceneOf(30, 15));
  scene.AddOdometryPriors();
  EXPECT_THAT(AdjustBundle(Options(), &scene.problem).obstacle, HasSubstr("see 10 points"));
  ExpectUntouched(scene);
}

TEST(AdjustBundle, RefusesWhatHasNoScale) {
  BundleScene scene = MakeBundleScene(SceneOf(30, 400));
  EXPECT_THAT(AdjustBundle(Options(), &scene.problem).obstacle, HasSubstr("scale"));
  ExpectUntouched(scene);
}

TEST(AdjustBundle, RefusesPiecesThatNothingConnects) {
  BundleScene scene = MakeBundleScene(SceneOf(40, 500));
  scene.AddOdometryPriors();
  scene.problem.relative_priors.erase(scene.problem.relative_priors.begin() + 19);
  for (std::size_t i = 20; i < 40; ++i) {
    for (Descriptor& descriptor : scene.problem.images[i].descriptors) {
      for (std::uint64_t& word : descriptor.words) {
        word ^= 0xf0f0f0f0f0f0f0f0U;  // another place
      }
    }
  }
  EXPECT_THAT(AdjustBundle(Options(), &scene.problem).obstacle, HasSubstr("2 groups"));
  ExpectUntouched(scene);
}

TEST(AdjustBundle, ChecksItsInput) {
  BundleScene scene = MakeBundleScene(SceneOf(5, 50));
  scene.AddOdometryPriors();
  BundleOptions options = Options();
  options.rounds = 0;
  EXPECT_THROW(AdjustBundle(options, &scene.problem), CheckError);
  scene.problem.relative_priors[0].to = 5;
  EXPECT_THROW(AdjustBundle(Options(), &scene.problem), CheckError);
}

}  // namespace
}  // namespace deja_view
