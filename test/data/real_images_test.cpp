// Features, words and place scores on real images: the pairs of EuRoC images that show one place,
// pieces of EuRoC V1_01, and 7-Scenes' red kitchen with its poses.

#include "deja_view/features/hamming_matcher.hpp"
#include "deja_view/features/make_feature_extractor.hpp"
#include "deja_view/place/place_database.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

fs::path DataFolder(const std::string& name) {
  const char* data = std::getenv("DEJA_VIEW_DATA");
  return data != nullptr && *data != '\0' ? fs::path(data) / name : fs::path();
}

cv::Mat ReadGrey(const fs::path& path) {
  return cv::imread(path.string(), cv::IMREAD_GRAYSCALE);
}

/// Extractor, vocabulary and database of one kind of descriptor, with defaults.
class PlaceRecogniser {
 public:
  explicit PlaceRecogniser(const std::string& kind) {
    FeatureOptions options;
    options.kind = kind == "orb" ? FeatureKind::kOrb : FeatureKind::kBrief;
    extractor_ = MakeFeatureExtractor(options);
    vocabulary_ = Vocabulary::Open(fs::path(DEJA_VIEW_CONFIG_DIR) / "vocabulary" / (kind + ".dvv"));
    database_ = std::make_unique<PlaceDatabase>(PlaceDatabaseOptions{}, vocabulary_);
  }

  Features Extract(const cv::Mat& image) const { return extractor_->Extract(image); }
  BowVector Bag(const cv::Mat& image) const { return vocabulary_->Bag(Extract(image).descriptors); }
  double Score(const BowVector& a, const BowVector& b) const { return database_->Score(a, b); }

 private:
  std::unique_ptr<FeatureExtractor> extractor_;
  std::shared_ptr<const Vocabulary> vocabulary_;
  std::unique_ptr<PlaceDatabase> database_;
};

/// Each other's nearest descriptors, well ahead of the second nearest.
int EpipolarInliers(const Features& a, const Features& b) {
  constexpr int kMaxDistance = 80;  // [bit]
  constexpr double kMaxRatio = 0.9;
  const auto forward = MatchHamming(a.descriptors, b.descriptors, kMaxDistance);
  const auto backward = MatchHamming(b.descriptors, a.descriptors, kMaxDistance);
  std::vector<cv::Point2f> points_a;
  std::vector<cv::Point2f> points_b;
  for (std::size_t i = 0; i < forward.size(); ++i) {
    const HammingMatch& match = forward[i];
    if (match.best < 0 || match.best_distance > kMaxRatio * match.second_distance) {
      continue;
    }
    const auto j = static_cast<std::size_t>(match.best);
    if (backward[j].best == static_cast<std::int32_t>(i)) {
      points_a.emplace_back(a.keypoints[i].x, a.keypoints[i].y);
      points_b.emplace_back(b.keypoints[j].x, b.keypoints[j].y);
    }
  }
  if (points_a.size() < 8) {
    return 0;
  }
  cv::setRNGSeed(1);
  std::vector<unsigned char> is_inlier;
  cv::findFundamentalMat(points_a, points_b, cv::FM_RANSAC, 3.0, 0.999, 2000, is_inlier);
  return static_cast<int>(std::count(is_inlier.begin(), is_inlier.end(), 1));
}

class RealImagesTest : public testing::TestWithParam<std::string> {
 protected:
  PlaceRecogniser recogniser_{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Kinds,
                         RealImagesTest,
                         testing::Values("brief", "orb"),
                         [](const auto& instance) { return instance.param; });

// Images 0 and 1 show one place, 2 and 3 another.
TEST_P(RealImagesTest, LoopPairsFindEachOther) {
  const fs::path folder = DataFolder("euroc_loop_pairs");
  if (!fs::is_directory(folder)) {
    GTEST_SKIP() << "DEJA_VIEW_DATA does not name a directory with euroc_loop_pairs";
  }
  std::array<Features, 4> features;
  std::array<BowVector, 4> bags;
  for (std::size_t i = 0; i < 4; ++i) {
    const cv::Mat image = ReadGrey(folder / ("left_img_" + std::to_string(i) + ".png"));
    ASSERT_FALSE(image.empty());
    features[i] = recogniser_.Extract(image);
    bags[i] = recogniser_.Bag(image);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t pair = i ^ 1U;
    const double score = recogniser_.Score(bags[i], bags[pair]);
    const int inliers = EpipolarInliers(features[i], features[pair]);
    RecordProperty("score_" + std::to_string(i), std::to_string(score));
    RecordProperty("inliers_" + std::to_string(i), inliers);
    EXPECT_GE(inliers, 40) << i;
    double other_score = 0;
    int other_inliers = 0;
    for (std::size_t other = 0; other < 4; ++other) {
      if (other != i && other != pair) {
        other_score = std::max(other_score, recogniser_.Score(bags[i], bags[other]));
        other_inliers = std::max(other_inliers, EpipolarInliers(features[i], features[other]));
      }
    }
    RecordProperty("other_score_" + std::to_string(i), std::to_string(other_score));
    RecordProperty("other_inliers_" + std::to_string(i), other_inliers);
    EXPECT_GT(score, 1.3 * other_score) << i;
    EXPECT_GT(inliers, 2 * other_inliers) << i;
  }
}

// The drone stands still in the first piece of V1_01 and looks elsewhere (by 85 degrees and more)
// in the second.
TEST_P(RealImagesTest, PiecesOfV101AreToldApart) {
  const fs::path folder = DataFolder("euroc_v101") / "images";
  if (!fs::is_directory(folder)) {
    GTEST_SKIP() << "DEJA_VIEW_DATA does not name a directory with euroc_v101/images";
  }
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(folder)) {
    paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<BowVector> standing;
  std::vector<BowVector> flying;
  for (std::size_t i = 0; i < paths.size(); i += 5) {
    const bool is_flying = paths[i].stem().string() > "1403715280";
    (is_flying ? flying : standing).push_back(recogniser_.Bag(ReadGrey(paths[i])));
  }
  ASSERT_GE(standing.size(), 10U);
  ASSERT_GE(flying.size(), 10U);
  double apart = 0;  // highest score between the pieces
  for (const BowVector& a : standing) {
    for (const BowVector& b : flying) {
      apart = std::max(apart, recogniser_.Score(a, b));
    }
  }
  RecordProperty("apart", std::to_string(apart));
  for (std::size_t i = 1; i < standing.size(); ++i) {
    EXPECT_GT(recogniser_.Score(standing[0], standing[i]), 2 * apart) << i;
  }
  for (std::size_t i = 1; i < flying.size(); ++i) {
    EXPECT_GT(recogniser_.Score(flying[i - 1], flying[i]), apart) << i;
  }
}

struct PosedBag {
  int frame = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // [m]
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();      // the camera's z in the world
  BowVector bag;
};

std::vector<PosedBag> ReadKitchen(const fs::path& folder, const PlaceRecogniser& recogniser) {
  std::vector<PosedBag> frames;
  for (int frame = 0; frame < 1000; frame += 8) {
    const std::string stem = fmt::format("frame-{:06d}", frame);
    std::ifstream file(folder / (stem + ".pose.txt"));
    Eigen::Matrix4d T_W_C;
    for (int i = 0; i < 16; ++i) {
      file >> T_W_C(i / 4, i % 4);
    }
    const cv::Mat image = ReadGrey(folder / (stem + ".color.jpg"));
    if (file && !image.empty()) {
      frames.push_back(
          {frame, T_W_C.block<3, 1>(0, 3), T_W_C.block<3, 1>(0, 2), recogniser.Bag(image)});
    }
  }
  return frames;
}

// Of the frames that come back to within 0.3 m and 15 degrees of an old one, most find one within
// 0.6 m and 30 degrees as their best match among all frames older than 10 s.
TEST_P(RealImagesTest, KitchenIsRecognised) {
  const fs::path folder = DataFolder("redkitchen");
  if (!fs::is_directory(folder)) {
    GTEST_SKIP() << "DEJA_VIEW_DATA does not name a directory with redkitchen";
  }
  const std::vector<PosedBag> frames = ReadKitchen(folder, recogniser_);
  ASSERT_GE(frames.size(), 100U);
  const auto is_near = [](const PosedBag& a, const PosedBag& b, double metres, double degrees) {
    return (a.position - b.position).norm() < metres &&
           a.axis.dot(b.axis) > std::cos(degrees * M_PI / 180);
  };
  int revisits = 0;
  int found = 0;
  for (const PosedBag& current : frames) {
    bool is_revisit = false;
    double best_score = -1;
    const PosedBag* best = nullptr;
    for (const PosedBag& old : frames) {
      if (old.frame + 300 > current.frame) {
        break;
      }
      is_revisit = is_revisit || is_near(old, current, 0.3, 15);
      const double score = recogniser_.Score(current.bag, old.bag);
      if (score > best_score) {
        best_score = score;
        best = &old;
      }
    }
    revisits += is_revisit ? 1 : 0;
    found += is_revisit && is_near(*best, current, 0.6, 30) ? 1 : 0;
  }
  RecordProperty("revisits", revisits);
  RecordProperty("found", found);
  ASSERT_GE(revisits, 10);
  EXPECT_GE(found, 0.7 * revisits);
}

}  // namespace
}  // namespace deja_view
