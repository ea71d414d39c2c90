#include "triangulation.hpp"

#include <cmath>

#include "bundle_scene.hpp"
#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

/// Cameras side by side, `apart` [m], that look along z at points without noise.
class Triangulation : public ::testing::Test {
 protected:
  void Look(int cameras, double apart) {
    problem_ = {};
    problem_.cameras.push_back({std::make_shared<PinholeCamera>(test::BundleLens()), {}, 0.0});
    for (int i = 0; i < cameras; ++i) {
      problem_.images.emplace_back().T_W_B.t.x() = apart * i;
    }
  }
  /// Adds a keypoint of `p_W` to an image.
  BundleObservation See(int image, const Eigen::Vector3d& p_W) {
    BundleImage& i = problem_.images[static_cast<std::size_t>(image)];
    const Rigid3 T_C_W = problem_.CameraPose(image).Inverse();
    i.keypoints.push_back(problem_.cameras[0].camera->Project(T_C_W * p_W).value().cast<float>());
    return {image, static_cast<int>(i.keypoints.size()) - 1};
  }
  std::vector<BundlePoint> Run(const Track& track) {
    return Triangulate(options_, problem_, UnprojectKeypoints(problem_, 1), {track}, 2.0);
  }

  BundleOptions options_;
  BundleProblem problem_;
  const Eigen::Vector3d p_W_{0.4, 0.2, 3};
};

TEST_F(Triangulation, FindsThePoint) {
  Look(4, 0.3);
  Track track;
  for (int i = 0; i < 4; ++i) {
    track.push_back(See(i, p_W_));
  }
  const auto points = Run(track);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_LT((points[0].p_W - p_W_).norm(), 1e-4);
  EXPECT_EQ(points[0].observations, track);
  EXPECT_NEAR(points[0].parallax_rad, 0.9 / 3, 0.02);
  for (const double error : ReprojectionErrors(problem_, points[0])) {
    EXPECT_LT(error, 1e-2);
  }
}

TEST_F(Triangulation, LeavesOutWhatDoesNotAgree) {
  Look(5, 0.3);
  Track track;
  for (int i = 0; i < 4; ++i) {
    track.push_back(See(i, p_W_));
  }
  track.push_back(See(4, p_W_ + Eigen::Vector3d(0, 0.3, 0)));
  const auto points = Run(track);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].observations.size(), 4U);
  EXPECT_LT((points[0].p_W - p_W_).norm(), 1e-4);
}

TEST_F(Triangulation, SplitsATrackThatJumped) {
  Look(8, 0.2);
  const Eigen::Vector3d other = p_W_ + Eigen::Vector3d(0.1, 0.3, 0.5);
  Track track;
  for (int i = 0; i < 8; ++i) {
    track.push_back(See(i, i < 4 ? p_W_ : other));
  }
  const auto points = Run(track);
  ASSERT_EQ(points.size(), 2U);
  EXPECT_LT((points[0].p_W - p_W_).norm() + (points[1].p_W - other).norm(), 1e-3);
}

TEST_F(Triangulation, RefusesWhatHasNoParallax) {
  Look(4, 0.01);
  Track track;
  for (int i = 0; i < 4; ++i) {
    track.push_back(See(i, p_W_));
  }
  EXPECT_TRUE(Run(track).empty());
}

TEST_F(Triangulation, RefusesTwoViewsWhereThreeAreWanted) {
  Look(2, 0.5);
  const Track track = {See(0, p_W_), See(1, p_W_)};
  EXPECT_TRUE(Run(track).empty());
  options_.min_views = 2;
  EXPECT_EQ(Run(track).size(), 1U);
}

}  // namespace
}  // namespace deja_view::internal
