#include "deja_view/bundle/bundle_adjuster.hpp"

#include "bundle_scene.hpp"
#include "bundle_solver.hpp"
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

/// True points in place, as the first six images see them.
test::BundleScene SmallScene() {
  test::BundleSceneOptions options = test::SceneOf(60, 60);
  options.step_noise_m = 0;
  options.yaw_noise_deg = 0;
  test::BundleScene scene = test::MakeBundleScene(options);
  scene.AddPosePriors();
  std::vector<BundlePoint> points(scene.points.size());
  for (int i = 0; i < 6; ++i) {
    const std::vector<int>& seen = scene.point_of_keypoint[static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < seen.size(); ++k) {
      BundlePoint& point = points[static_cast<std::size_t>(seen[k])];
      point.p_W = scene.points[static_cast<std::size_t>(seen[k])];
      point.observations.push_back({i, static_cast<int>(k)});
    }
  }
  for (const BundlePoint& point : points) {
    if (point.observations.size() >= 2) {
      scene.problem.points.push_back(point);
    }
  }
  return scene;
}

TEST(PoseCovariances, AreBlocksOfTheInverseOfTheWholeInformation) {
  const test::BundleScene scene = SmallScene();
  std::vector<int> points(scene.problem.points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = static_cast<int>(i);
  }
  ASSERT_GT(points.size(), 5U);
  internal::BundleSolver solver({}, scene.problem, points);
  const Eigen::MatrixXd J = solver.Linearise().J;
  const Eigen::MatrixXd covariance = (J.transpose() * J).inverse();
  const auto found = PoseCovariances({}, scene.problem, {0, 4});
  ASSERT_EQ(found.size(), 2U);
  // Here (t, w), there (w, t).
  EXPECT_TRUE((found[1].topLeftCorner<3, 3>().isApprox(covariance.block<3, 3>(27, 27), 1e-4)));
  EXPECT_TRUE((found[1].bottomRightCorner<3, 3>().isApprox(covariance.block<3, 3>(24, 24), 1e-4)));
  EXPECT_TRUE((found[0].topRightCorner<3, 3>().isApprox(covariance.block<3, 3>(3, 0), 1e-3)));
}

}  // namespace
}  // namespace deja_view
