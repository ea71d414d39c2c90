#include "deja_view/views/view_maker.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/camera/depth_image.hpp"

#include "room_renderer.hpp"
#include "test_cameras.hpp"
#include <gmock/gmock.h>
#include <opencv2/core.hpp>

namespace deja_view {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::int64_t kStamp = 1403636632538560256;

ViewSource MakeSource() {
  ViewSource source;
  source.stamp_ns = kStamp;
  source.T_N_C = {ExpSo3({0.1, 0.3, 0}), {0.5, 0.2, -0.3}};
  source.image = RoomRenderer().Render(*BentCamera(), source.T_N_C, {0.8F, 0.1F, 1}).image;
  return source;
}

ViewOptions Wide() {
  ViewOptions options;
  options.fit_scale = 0.5;
  options.sampling.views = 4;
  options.sampling.radius_m = 0.8;
  options.sampling.min_radius_m = 0.3;
  options.sampling.spacing_min_m = 0.3;
  options.sampling.spacing_max_m = 1;
  options.sampling.rotation_deg = 20;
  return options;
}

ViewMaker MakeMaker(const ViewOptions& options, const ViewContent& content) {
  return {options, content, BentCamera(), {}, 99};
}

TEST(ViewMakerTest, MakesTheChosenPosesAndTheImageItself) {
  ViewSource source = MakeSource();
  source.image.setTo(7, source.image > 200);  // what no render shows
  const Rigid3 chosen = {ExpSo3({0, 0.1, 0}), {0.4, 0, 0.1}};
  source.chosen = ChosenViews{{chosen}, 3, 2};
  ViewOptions options = Wide();
  options.own_image = true;
  const MadeViews made = MakeMaker(options, {true, false, true}).Make(source, RoomRenderer(), 1);
  ASSERT_THAT(made.views, SizeIs(2));
  EXPECT_EQ(made.views[0].T_C_V.t, Eigen::Vector3d::Zero());
  EXPECT_EQ(cv::norm(made.views[0].image, source.image, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(made.views[0].depth_mm,
                     ToMillimetres(RoomRenderer().Render(*BentCamera(), source.T_N_C, {}).depth),
                     cv::NORM_INF),
            0);
  EXPECT_EQ(made.views[1].T_C_V.t, chosen.t);
  EXPECT_EQ(made.views[1].count, 2);
  EXPECT_EQ(made.not_free, 3);
  EXPECT_EQ(made.uncertain, 2);
}

TEST(ViewMakerTest, MakesWhatACameraThereWouldSee) {
  const ViewSource source = MakeSource();
  const MadeViews made = MakeMaker(Wide(), {true, true, true}).Make(source, RoomRenderer(), 1);
  EXPECT_TRUE(made.is_recognised);
  EXPECT_NEAR(made.fit.gain, 0.8, 0.02);
  EXPECT_NEAR(made.fit.bias, 0.1, 0.02);
  ASSERT_THAT(made.views, SizeIs(4));
  for (int i = 0; i < 4; ++i) {
    const VirtualView& view = made.views[static_cast<std::size_t>(i)];
    EXPECT_EQ(view.stamp_ns, kStamp);
    EXPECT_EQ(view.index, i);
    EXPECT_EQ(view.count, 4);
    EXPECT_EQ(view.settings_hash, 99U);
    const RenderedView truth =
        RoomRenderer().Render(*BentCamera(), source.T_N_C * view.T_C_V, {0.8F, 0.1F, 1});
    EXPECT_LE(cv::norm(view.image, truth.image, cv::NORM_INF), 8);  // the fitted exposure
    EXPECT_EQ(view.depth_mm.at<std::uint16_t>(5, 9),
              std::lround(1000 * static_cast<double>(truth.depth.at<float>(5, 9))));
    EXPECT_EQ(view.certainty.at<std::uint8_t>(5, 9), 252);
    EXPECT_EQ(view.features.descriptor, "brief");
    EXPECT_GT(view.features.depth_m.size(), 50U);
  }
}

TEST(ViewMakerTest, CarriesWhatIsAskedFor) {
  const MadeViews made =
      MakeMaker(Wide(), {false, true, false}).Make(MakeSource(), RoomRenderer(), 1);
  ASSERT_THAT(made.views, SizeIs(4));
  EXPECT_TRUE(made.views[0].image.empty());
  EXPECT_TRUE(made.views[0].depth_mm.empty());
  EXPECT_FALSE(made.views[0].features.descriptor.empty());
  EXPECT_THROW(MakeMaker(Wide(), {false, false, true}), CheckError);
}

TEST(ViewMakerTest, MayKeepTheScenesExposure) {
  ViewOptions options = Wide();
  options.exposure = ViewExposure::kNeutral;
  const ViewSource source = MakeSource();
  const MadeViews made = MakeMaker(options, {}).Make(source, RoomRenderer(), 1);
  const VirtualView& view = made.views.at(0);
  const RenderedView truth = RoomRenderer().Render(*BentCamera(), source.T_N_C * view.T_C_V, {});
  EXPECT_EQ(cv::norm(view.image, truth.image, cv::NORM_INF), 0);
}

TEST(ViewMakerTest, MakesNothingWhereTheModelShowsSomethingElse) {
  ViewSource source = MakeSource();
  source.T_N_C.t.x() -= 3;
  const MadeViews made = MakeMaker(Wide(), {}).Make(source, RoomRenderer(), 1);
  EXPECT_FALSE(made.is_recognised);
  EXPECT_THAT(made.views, IsEmpty());
}

TEST(ViewMakerTest, CountsPosesThatAreNotOffered) {
  ViewSource source = MakeSource();
  source.T_N_C = {Eigen::Quaterniond::Identity(), {3.5, 0, 0}};  // beside the wall
  source.image = RoomRenderer().Render(*BentCamera(), source.T_N_C, {}).image;
  const MadeViews made = MakeMaker(Wide(), {}).Make(source, RoomRenderer(), 1);
  EXPECT_GT(made.not_free, 0);
  for (const VirtualView& view : made.views) {
    EXPECT_LT((source.T_N_C * view.T_C_V.t).x(), 4);
  }
  const MadeViews unsure = MakeMaker(Wide(), {}).Make(source, RoomRenderer(0.2), 1);
  EXPECT_THAT(unsure.views, IsEmpty());
  EXPECT_GT(unsure.uncertain, 0);
}

TEST(ViewMakerTest, RefusesAnImageOfAnotherSize) {
  ViewSource source = MakeSource();
  source.image = source.image.colRange(0, 300);
  EXPECT_THROW(MakeMaker(Wide(), {}).Make(source, RoomRenderer(), 1), CheckError);
}

TEST(ViewMakerTest, OptionsNameTheirGroup) {
  ViewOptions options;
  options.sampling.views = -1;
  options.rendering.method = Upscaling::kFsrcnn;
  options.rendering.network.clear();
  options.jpeg_quality = 0;
  EXPECT_THAT(options.Validate(),
              ::testing::ElementsAre(::testing::HasSubstr("sampling.views: -1"),
                                     ::testing::HasSubstr("rendering.network is empty"),
                                     ::testing::HasSubstr("jpeg_quality: 0")));
}

}  // namespace
}  // namespace deja_view
