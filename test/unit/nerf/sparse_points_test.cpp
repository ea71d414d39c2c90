#include "deja_view/nerf/sparse_points.hpp"

#include <cmath>
#include <memory>
#include <random>

#include "test_cameras.hpp"
#include "viewed_scene.hpp"
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace deja_view::nerf {
namespace {

constexpr double kWall = 4;  ///< [m] along z

std::shared_ptr<const Camera> MakeCamera() {
  return SharedPinholeOf(320, 240, 240, 159.5, 119.5);
}

// Random grey squares of 8 cm on the plane z = kWall.
cv::Mat MakeTexture() {
  std::mt19937 rng(3);
  std::uniform_int_distribution<int> grey(0, 255);
  cv::Mat texture(100, 100, CV_8UC1);
  for (int i = 0; i < 10000; ++i) {
    texture.at<std::uint8_t>(i / 100, i % 100) = static_cast<std::uint8_t>(grey(rng));
  }
  return texture;
}

TrainingView MakeView(const std::shared_ptr<const Camera>& camera, const Rigid3& T_N_C) {
  static const cv::Mat kTexture = MakeTexture();
  return ViewOf(camera, T_N_C, [&](const Eigen::Vector3d& ray) {
    const Eigen::Vector3d p = T_N_C.t + (kWall - T_N_C.t.z()) / ray.z() * ray;
    const int u = static_cast<int>(std::floor(p.x() / 0.08)) + 50;
    const int v = static_cast<int>(std::floor(p.y() / 0.08)) + 50;
    return kTexture.at<std::uint8_t>(std::clamp(v, 0, 99), std::clamp(u, 0, 99));
  });
}

std::vector<TrainingView> MakeViews() {
  const auto camera = MakeCamera();
  std::vector<TrainingView> views;
  for (int i = 0; i < 8; ++i) {
    const double u = 0.15 * i;
    views.push_back(
        MakeView(camera, {ExpSo3({0.02 * std::sin(u), -0.03 * i, 0}), {u, 0.1 * std::sin(u), 0}}));
    views.back().name = std::to_string(i);
  }
  return views;
}

TEST(SparsePoints, LieOnTheWall) {
  std::vector<TrainingView> views = MakeViews();
  const std::size_t added = AddSparsePoints({}, 0, &views);
  EXPECT_GT(added, std::size_t{400});
  std::size_t points = 0;
  std::size_t good = 0;
  for (const TrainingView& view : views) {
    for (const DepthPoint& point : view.points) {
      const Eigen::Vector3d ray =
          view.T_N_C.q *
          view.camera->Unproject({static_cast<double>(point.u), static_cast<double>(point.v)});
      const double range = (kWall - view.T_N_C.t.z()) / ray.z();
      ++points;
      good += std::abs(static_cast<double>(point.range) - range) < 0.05 * range ? 1U : 0U;
    }
  }
  EXPECT_EQ(points, added);
  EXPECT_GT(static_cast<double>(good), 0.97 * static_cast<double>(points));
}

TEST(SparsePoints, DoNotDependOnThreads) {
  std::vector<TrainingView> one = MakeViews();
  std::vector<TrainingView> three = one;
  AddSparsePoints({}, 1, &one);
  AddSparsePoints({}, 3, &three);
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].points.size(), three[i].points.size());
    for (std::size_t p = 0; p < one[i].points.size(); ++p) {
      EXPECT_EQ(one[i].points[p].range, three[i].points[p].range);
    }
  }
}

TEST(SparsePoints, WrongPosesGiveFewPoints) {
  std::vector<TrainingView> right = MakeViews();
  std::vector<TrainingView> wrong = right;
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    wrong[i].T_N_C.t.y() += 0.4 * std::sin(5.0 * static_cast<double>(i));
  }
  EXPECT_LT(AddSparsePoints({}, 0, &wrong), AddSparsePoints({}, 0, &right) / 5);
}

TEST(SparsePoints, NoPairNoPoint) {
  std::vector<TrainingView> views = {MakeViews().front()};
  EXPECT_EQ(AddSparsePoints({}, 0, &views), std::size_t{0});
  // Two images from one place have no parallax.
  views.push_back(views.front());
  EXPECT_EQ(AddSparsePoints({}, 0, &views), std::size_t{0});
}

}  // namespace
}  // namespace deja_view::nerf
