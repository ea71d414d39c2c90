#include "deja_view/views/view_matching.hpp"

#include "deja_view/features/brief_extractor.hpp"

#include "room_renderer.hpp"
#include "test_cameras.hpp"
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

const Rigid3 kMatchedPose{ExpSo3({0.1, 0.3, 0}), {0.5, 0.2, -0.3}};
const Rigid3 kBeside{ExpSo3({0.02, 0.03, 0}), {0.1, 0, 0.05}};

struct View {
  RenderedView render;
  Features features;
};

View Look(const Rigid3& T_N_C) {
  View view;
  view.render = RoomRenderer().Render(*BentCamera(), T_N_C, {});
  view.features = BriefExtractor().Extract(view.render.image);
  return view;
}

TEST(ViewMatchingTest, AllMatchInTheSameImage) {
  const View view = Look(kMatchedPose);
  const MatchCount count =
      CountCorrectMatches(view.features, view.features, view.render.depth, *BentCamera(), {});
  EXPECT_EQ(count.visible, view.features.keypoints.size());
  EXPECT_EQ(count.correct, count.visible);
}

TEST(ViewMatchingTest, CountsWhatGeometryConfirms) {
  const View real = Look(kMatchedPose);
  const View beside = Look(kMatchedPose * kBeside);
  const MatchCount right = CountCorrectMatches(
      real.features, beside.features, real.render.depth, *BentCamera(), kBeside);
  EXPECT_LE(right.visible, real.features.keypoints.size());
  EXPECT_GT(right.correct, right.visible / 3);
  EXPECT_LE(right.correct, right.matched);
  EXPECT_LE(right.matched, right.visible);
  // With the inverse pose nearly nothing is where it should be.
  const MatchCount wrong = CountCorrectMatches(
      real.features, beside.features, real.render.depth, *BentCamera(), kBeside.Inverse());
  EXPECT_LT(wrong.correct, right.correct / 5);
}

TEST(ViewMatchingTest, BlurCostsMatches) {
  const View real = Look(kMatchedPose);
  View beside = Look(kMatchedPose * kBeside);
  const MatchCount sharp = CountCorrectMatches(
      real.features, beside.features, real.render.depth, *BentCamera(), kBeside);
  cv::GaussianBlur(beside.render.image, beside.render.image, {0, 0}, 4);
  const MatchCount blurred = CountCorrectMatches(real.features,
                                                 BriefExtractor().Extract(beside.render.image),
                                                 real.render.depth,
                                                 *BentCamera(),
                                                 kBeside);
  EXPECT_LT(blurred.correct, sharp.correct * 3 / 4);
}

TEST(ViewMatchingTest, PassesOverUnknownDepth) {
  const View view = Look(kMatchedPose);
  const cv::Mat none = cv::Mat::zeros(240, 320, CV_32FC1);
  EXPECT_EQ(CountCorrectMatches(view.features, view.features, none, *BentCamera(), {}).visible, 0U);
}

}  // namespace
}  // namespace deja_view
