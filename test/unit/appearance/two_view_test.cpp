#include "deja_view/appearance/two_view.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include <algorithm>
#include <random>
#include <utility>

#include "random_vocabulary.hpp"
#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

constexpr int kPoints = 60;
constexpr int kStrays = 20;

PinholeCamera MakePinhole() {
  PinholeParameters p;
  p.width = 640;
  p.height = 480;
  p.fx = p.fy = 400;
  p.cx = 320;
  p.cy = 240;
  p.k1 = -0.2;
  return PinholeCamera(p);
}

/// Two views of points in space, the last `kStrays` of which are torn apart.
std::pair<Features, Features> TwoViews(const Camera& camera) {
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()).toRotationMatrix();
  std::pair<Features, Features> views;
  for (int i = 0; i < kPoints; ++i) {
    const Eigen::Vector3d p(2 * unit(rng), 1.5 * unit(rng), 5 + 2 * unit(rng));
    Eigen::Vector3d q = turn * p + Eigen::Vector3d(0.6, 0.1, 0.2);
    if (i >= kPoints - kStrays) {
      q = {2 * unit(rng), 1.5 * unit(rng), 5};
    }
    const Eigen::Vector2f a = camera.Project(p).value().cast<float>();
    const Eigen::Vector2f b = camera.Project(q).value().cast<float>();
    views.first.keypoints.push_back({a.x(), a.y()});
    views.second.keypoints.push_back({b.x(), b.y()});
    const Descriptor descriptor = test::RandomDescriptor(&rng);
    views.first.descriptors.push_back(descriptor);
    views.second.descriptors.push_back(test::Disturb(descriptor, 20, &rng));
  }
  return views;
}

TEST(TwoView, CountsWhatOneGeometryExplains) {
  const PinholeCamera camera = MakePinhole();
  const auto [a, b] = TwoViews(camera);
  TwoViewOptions options;
  options.camera = &camera;
  const TwoViewResult essential = CompareTwoViews(a, b, options);
  EXPECT_EQ(essential.matches, kPoints);
  EXPECT_GE(essential.inliers, kPoints - kStrays);
  EXPECT_LE(essential.inliers, kPoints - kStrays + 5) << "strays near their line by chance";
  const TwoViewResult fundamental = CompareTwoViews(a, b);
  EXPECT_GE(fundamental.inliers, 30) << "the lens bends the lines";
  EXPECT_LE(fundamental.inliers, kPoints - kStrays + 8);
  EXPECT_EQ(CompareTwoViews(a, b).inliers, fundamental.inliers);
}

TEST(TwoView, MatchesMutuallyAndByRatio) {
  const PinholeCamera camera = MakePinhole();
  auto [a, b] = TwoViews(camera);
  // A point of b that looks like another of its points: which is meant can't be told.
  b.keypoints.push_back({1, 1});
  b.descriptors.push_back(b.descriptors[0]);
  // A point of a that is second choice of b's.
  std::mt19937_64 rng(5);
  a.keypoints.push_back({1, 1});
  a.descriptors.push_back(test::Disturb(b.descriptors[1], 40, &rng));
  EXPECT_EQ(CompareTwoViews(a, b).matches, kPoints - 1);
}

TEST(TwoView, AShiftIsOneGeometry) {
  const PinholeCamera camera = MakePinhole();
  const Features a = TwoViews(camera).first;
  Features b = a;
  for (Keypoint& keypoint : b.keypoints) {
    keypoint.x += 3;
  }
  EXPECT_GE(CompareTwoViews(a, b).inliers, kPoints - kStrays);
  TwoViewOptions options;
  options.camera = &camera;
  EXPECT_GE(CompareTwoViews(a, b, options).inliers, kPoints - kStrays);
}

TEST(TwoView, NothingInCommon) {
  const PinholeCamera camera = MakePinhole();
  auto [a, b] = TwoViews(camera);
  EXPECT_EQ(CompareTwoViews(a, Features()).matches, 0);
  EXPECT_EQ(CompareTwoViews(Features(), Features()).inliers, 0);
  a.keypoints.resize(8);
  a.descriptors.resize(8);
  EXPECT_EQ(CompareTwoViews(a, b).matches, 8);
  EXPECT_EQ(CompareTwoViews(a, b).inliers, 0) << "eight points obey some geometry";
  TwoViewOptions options;
  options.max_ratio = 0;
  options.confidence = 1;
  EXPECT_EQ(options.Validate().size(), 2U);
  EXPECT_THROW(CompareTwoViews(a, b, options), CheckError);
}

}  // namespace
}  // namespace deja_view
