#include "image_matching.hpp"

#include <algorithm>

#include "bundle_scene.hpp"
#include "image_pairs.hpp"
#include "track_builder.hpp"
#include "triangulation.hpp"
#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

class ImageMatching : public ::testing::Test {
 protected:
  void SetUp() override { MakeScene(0.3); }

  void MakeScene(double wrong_share) {
    test::BundleSceneOptions options;
    options.images = 60;
    options.points = 800;
    options.wrong_share = wrong_share;
    scene_ = test::MakeBundleScene(options);
    for (std::size_t i = 0; i < scene_.T_W_B.size(); ++i) {
      scene_.problem.images[i].T_W_B = scene_.T_W_B[i];
    }
    pairs_ = ChooseImagePairs(options_, scene_.problem);
    matches_ = MatchDescriptors(options_, scene_.problem, pairs_);
    rays_ = UnprojectKeypoints(scene_.problem, 1);
  }

  int PointOf(const BundleObservation& o) const {
    return scene_
        .point_of_keypoint[static_cast<std::size_t>(o.image)][static_cast<std::size_t>(o.keypoint)];
  }
  double WrongShare(const std::vector<KeypointMatch>& matches) const {
    const auto wrong = std::count_if(matches.begin(), matches.end(), [&](const KeypointMatch& m) {
      return PointOf(m.a) != PointOf(m.b);
    });
    return static_cast<double>(wrong) / static_cast<double>(matches.size());
  }

  BundleOptions options_;
  test::BundleScene scene_;
  std::vector<std::pair<int, int>> pairs_;
  std::vector<KeypointMatch> matches_;
  ImageRays rays_;
};

TEST_F(ImageMatching, EpipolarGeometryDropsMostWrongMatches) {
  EXPECT_GT(WrongShare(matches_), 0.05);
  const auto kept = KeepEpipolar(options_, scene_.problem, rays_, matches_, 3.0, false);
  EXPECT_LT(WrongShare(kept), 0.02);
  const auto right = [&](const std::vector<KeypointMatch>& matches) {
    return static_cast<double>(
        std::count_if(matches.begin(), matches.end(), [&](const KeypointMatch& m) {
          return PointOf(m.a) == PointOf(m.b);
        }));
  };
  EXPECT_GT(right(kept), 0.99 * right(matches_));
}

TEST_F(ImageMatching, ALoopsRelativePoseStandsInForWrongPoses) {
  // One image is far off; only a loop knows how it lies to another.
  const int a = pairs_.back().first;
  const int b = pairs_.back().second;
  const auto of_pair = [&](const std::vector<KeypointMatch>& matches) {
    return std::count_if(matches.begin(), matches.end(), [&](const KeypointMatch& m) {
      return m.a.image == a && m.b.image == b;
    });
  };
  const auto all = of_pair(KeepEpipolar(options_, scene_.problem, rays_, matches_, 3.0, true));
  const Rigid3 T = scene_.T_W_B[static_cast<std::size_t>(b)].Inverse() *
                   scene_.T_W_B[static_cast<std::size_t>(a)];
  scene_.problem.images[static_cast<std::size_t>(b)].T_W_B.q =
      ExpSo3({0.1, 0.2, 0.1}) * scene_.T_W_B[static_cast<std::size_t>(b)].q;
  scene_.problem.loops.push_back({b, a, T});
  const auto count = [&](bool use_loops) {
    return of_pair(KeepEpipolar(options_, scene_.problem, rays_, matches_, 3.0, use_loops));
  };
  EXPECT_LT(count(false), all / 4);
  EXPECT_GE(count(true), all);
}

TEST_F(ImageMatching, PointsAreFoundWhereTheyProject) {
  // A point of two images; every other image that sees it finds it.
  MakeScene(0.1);
  const BundleImage& image = scene_.problem.images[0];
  int found = 0;
  int expected = 0;
  for (int k = 0; k < static_cast<int>(image.keypoints.size()); ++k) {
    const int truth = PointOf({0, k});
    const auto& in_second = scene_.point_of_keypoint[1];
    const auto second = std::find(in_second.begin(), in_second.end(), truth);
    if (second != in_second.end()) {
      BundlePoint point;
      point.p_W = scene_.points[static_cast<std::size_t>(truth)];
      point.observations = {{0, k}, {1, static_cast<int>(second - in_second.begin())}};
      scene_.problem.points.push_back(point);
    }
  }
  const auto matches = SearchByProjection(options_, scene_.problem, {{0, 2}, {1, 2}}, 3.0);
  for (const KeypointMatch& m : matches) {
    EXPECT_EQ(m.b.image, 2);
    found += PointOf(m.a) == PointOf(m.b) ? 1 : 0;
  }
  for (const BundlePoint& point : scene_.problem.points) {
    const auto& in_third = scene_.point_of_keypoint[2];
    expected += static_cast<int>(
        std::count(in_third.begin(), in_third.end(), PointOf(point.observations.front())));
  }
  EXPECT_GT(expected, 20);
  EXPECT_GT(found, 0.8 * expected);  // a tenth of the descriptors is wrong
  EXPECT_GE(found, static_cast<int>(matches.size()) - 2);
}

}  // namespace
}  // namespace deja_view::internal
