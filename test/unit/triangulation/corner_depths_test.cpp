#include "deja_view/triangulation/corner_depths.hpp"

#include "deja_view/base/random.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include <cmath>
#include <vector>

#include "test_cameras.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

PinholeCamera TestCamera() {
  return PinholeOf(752, 480, 458, 375, 239);
}

/// Points before the camera, with descriptors of their own.
struct Scene {
  explicit Scene(int count, std::uint64_t seed = 1) {
    Random random(seed);
    for (int i = 0; i < count; ++i) {
      points.emplace_back(random.Uniform(-3, 3), random.Uniform(-1.8, 1.8), random.Uniform(2.5, 8));
      Descriptor descriptor;
      for (auto& word : descriptor.words) {
        word = random.Next();
      }
      descriptors.push_back(descriptor);
    }
  }
  /// The corners of an image taken from T_W_C, at whole pixels; `shown[i]` is corner i's point.
  CornerView Film(const Rigid3& T_W_C,
                  const Camera& camera,
                  std::vector<std::size_t>* shown) const {
    std::vector<Eigen::Vector2f> pixels;
    std::vector<Descriptor> seen;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto pixel = camera.Project(T_W_C.Inverse() * points[i]);
      if (pixel && camera.IsInImage(*pixel)) {
        pixels.emplace_back(std::round(pixel->x()), std::round(pixel->y()));
        seen.push_back(descriptors[i]);
        shown->push_back(i);
      }
    }
    return MakeCornerView(pixels, seen, camera);
  }
  std::vector<Eigen::Vector3d> points;
  std::vector<Descriptor> descriptors;
};

class TriangulatePairTest : public testing::Test {
 protected:
  void Film(const Rigid3& T_W_a, const Rigid3& T_W_b) {
    T_W_a_ = T_W_a;
    T_b_a_ = T_W_b.Inverse() * T_W_a;
    a_ = scene_.Film(T_W_a, camera_, &in_a_);
    b_ = scene_.Film(T_W_b, camera_, &in_b_);
  }
  int Match(const Rigid3& T_b_a, const PoseNoise& noise = {}) {
    return TriangulatePair(T_b_a, noise, camera_, options_, &a_, &b_);
  }
  double TrueDepth(std::size_t corner) const {
    return (T_W_a_.Inverse() * scene_.points[in_a_[corner]]).norm();
  }
  /// Root mean square of (inverse depth - truth) over sigma, of the corners whose depth is known.
  double NormalisedError() const {
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < a_.depths.size(); ++i) {
      if (a_.depths[i].is_known()) {
        sum += std::pow((a_.depths[i].mean - 1 / TrueDepth(i)) / a_.depths[i].sigma, 2);
        ++count;
      }
    }
    return std::sqrt(sum / count);
  }

  PinholeCamera camera_ = TestCamera();
  TriangulationOptions options_;
  Scene scene_{300};
  Rigid3 T_W_a_;
  Rigid3 T_b_a_;
  CornerView a_, b_;
  std::vector<std::size_t> in_a_, in_b_;
};

const Rigid3 kAside{ExpSo3({0.02, -0.1, 0.05}), {0.4, 0.05, -0.1}};

TEST_F(TriangulatePairTest, FindsDepthsToWithinTheirDeviations) {
  Film({}, kAside);
  const int pairs = Match(T_b_a_);
  EXPECT_GT(pairs, 0.8 * static_cast<double>(a_.pixels.size()));
  EXPECT_LT(NormalisedError(), 1.2);
  int certain = 0;
  for (std::size_t i = 0; i < a_.depths.size(); ++i) {
    if (IsCertain(a_.depths[i], options_)) {
      ++certain;
      EXPECT_NEAR(1 / a_.depths[i].mean, TrueDepth(i), 0.15 * TrueDepth(i));
    }
  }
  EXPECT_GT(certain, 0.7 * static_cast<double>(a_.pixels.size()));
}

TEST_F(TriangulatePairTest, TellsBothSides) {
  Film({}, kAside);
  const int pairs = Match(T_b_a_);
  int known = 0;
  for (std::size_t j = 0; j < b_.depths.size(); ++j) {
    if (b_.depths[j].is_known()) {
      ++known;
      const double depth = (kAside.Inverse() * scene_.points[in_b_[j]]).norm();
      EXPECT_NEAR(b_.depths[j].mean, 1 / depth, 4 * b_.depths[j].sigma);
    }
  }
  EXPECT_EQ(known, pairs);
}

TEST_F(TriangulatePairTest, CornersOffTheEpipolarCurveAreNoPairs) {
  Film({}, kAside);
  EXPECT_LT(Match(Rigid3{ExpSo3({0.1, 0, 0}), Eigen::Vector3d::Zero()} * T_b_a_), 10);
}

TEST_F(TriangulatePairTest, ANoisyPoseIsAllowedForAndTold) {
  Film({}, kAside);
  const Rigid3 wrong = Rigid3{ExpSo3({0.01, 0, 0}), Eigen::Vector3d::Zero()} * T_b_a_;  // 4.6 px
  const int without = Match(wrong);
  a_.depths.assign(a_.depths.size(), {});
  b_.depths.assign(b_.depths.size(), {});
  EXPECT_GT(Match(wrong, {0.0, 0.01}), 2 * without);
  EXPECT_LT(NormalisedError(), 1.2);
}

TEST_F(TriangulatePairTest, ALikeCornerElsewhereOnTheCurveLeavesThePairOut) {
  Film({}, kAside);
  const int pairs = Match(T_b_a_);
  a_.depths.assign(a_.depths.size(), {});
  b_.depths.assign(b_.depths.size(), {});
  // Half a metre behind its point, every corner's ray shows the same once more.
  std::vector<Eigen::Vector2f> pixels = b_.pixels;
  std::vector<Descriptor> descriptors = b_.descriptors;
  for (std::size_t i = 0; i < a_.pixels.size(); ++i) {
    const Eigen::Vector3d ray = a_.rays[i].cast<double>();
    const auto pixel = camera_.Project(T_b_a_ * ((TrueDepth(i) / 1.5) * ray));
    if (pixel && camera_.IsInImage(*pixel)) {
      pixels.push_back(pixel->cast<float>());
      descriptors.push_back(a_.descriptors[i]);
    }
  }
  b_ = MakeCornerView(pixels, descriptors, camera_);
  EXPECT_LT(Match(T_b_a_), pairs / 4);
}

TEST_F(TriangulatePairTest, ASecondPairNarrowsAndAContradictionIsLeftOut) {
  Film({}, kAside);
  Match(T_b_a_);
  const std::vector<InverseDepth> first = a_.depths;
  std::vector<std::size_t> ignored;
  const Rigid3 T_W_c{ExpSo3({0, 0.1, 0}), {-0.5, 0.1, 0}};
  b_ = scene_.Film(T_W_c, camera_, &ignored);
  Match(T_W_c.Inverse());
  EXPECT_LT(NormalisedError(), 1.3);
  int narrowed = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_LE(first[i].matches, a_.depths[i].matches);
    narrowed += a_.depths[i].matches == 2 && a_.depths[i].sigma < first[i].sigma ? 1 : 0;
  }
  EXPECT_GT(narrowed, 100);
  const std::vector<InverseDepth> second = a_.depths;
  for (InverseDepth& depth : a_.depths) {
    depth.mean *= 2;
    depth.sigma *= 0.1F;
  }
  b_.depths.assign(b_.depths.size(), {});
  EXPECT_LT(Match(T_W_c.Inverse()), 10);
}

TEST_F(TriangulatePairTest, ACornerTakesOverWhatItsPartnerKnew) {
  Film({}, kAside);
  Match(T_b_a_);
  // A new image beside b: too little parallax to measure by itself.
  const Rigid3 T_W_c = kAside * Rigid3{Eigen::Quaterniond::Identity(), {0.02, 0, 0}};
  std::vector<std::size_t> in_c;
  CornerView c = scene_.Film(T_W_c, camera_, &in_c);
  TriangulatePair(kAside.Inverse() * T_W_c, {}, camera_, options_, &c, &b_);
  int certain = 0;
  for (std::size_t i = 0; i < c.depths.size(); ++i) {
    if (IsCertain(c.depths[i], options_)) {
      ++certain;
      const double depth = (T_W_c.Inverse() * scene_.points[in_c[i]]).norm();
      EXPECT_NEAR(c.depths[i].mean, 1 / depth, 4 * c.depths[i].sigma);
    }
  }
  EXPECT_GT(certain, 150);
}

TEST_F(TriangulatePairTest, WithoutMotionNothingIsCertain) {
  Film({}, {});
  Match(T_b_a_);
  EXPECT_THAT(a_.depths, testing::Each(testing::Truly([&](const InverseDepth& depth) {
                return !IsCertain(depth, options_);
              })));
}

TEST(TriangulationOptionsTest, ViolationsAreListed) {
  TriangulationOptions options;
  EXPECT_TRUE(options.Validate().empty());
  options.min_depth_m = 0;
  options.max_ratio = 2;
  EXPECT_EQ(options.Validate().size(), 2U);
}

}  // namespace
}  // namespace deja_view
