#include "deja_view/scene/open_scene_model.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/nerf/checkpoint.hpp"
#include "deja_view/nerf/scene_cells.hpp"

#include "temporary_directory.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace deja_view {
namespace {

using testing::HasSubstr;

class OpenSceneModelTest : public TemporaryDirectoryTest {
 protected:
  std::filesystem::path WriteField(const nerf::FieldFrame& frame) const {
    nerf::FieldOptions options;
    options.geometry = {3, 2, 12, 4, 16};
    options.appearance = {2, 4, 10, 8, 32};
    options.color_hidden = 16;
    options.occupancy_resolution = 8;
    nerf::RadianceField field(options, {}, {}, 1, 1);
    field.exposures = {{"one", 10, 1.5F, 0.25F, {}}};
    field.cells = {1, nerf::CutByCameras({{0, 0, 0}, {2, 0, 0}}, 2)};
    field.frame = frame;
    nerf::WriteField(directory_ / "field.dvn", field);
    return directory_ / "field.dvn";
  }

  const std::shared_ptr<const Camera> camera_ =
      std::make_shared<PinholeCamera>(PinholeParameters{8, 6, 5, 5, 3.5, 2.5, 0, 0, 0, 0});
};

TEST_F(OpenSceneModelTest, AFieldHasItsRendererFrameExposureAndCells) {
  const auto path = WriteField({true, {2.5, {}}});
  const auto model = OpenSceneModel(path);
  EXPECT_EQ(model->FindFrame(std::nullopt).scale, 2.5);
  EXPECT_EQ(model->FindFrame(Similarity3{4, {}}).scale, 4);
  EXPECT_EQ(model->ExposureAt(10).gain, 1.5F);
  EXPECT_EQ(model->ExposureAt(10).bias, 0.25F);
  EXPECT_EQ(model->cells().index, 1);
  EXPECT_TRUE(model->cells().IsOwn({2, 0, 0}));
  EXPECT_FALSE(model->NeedsPoints());
  EXPECT_THAT(model->Describe(), HasSubstr("field.dvn"));
  EXPECT_EQ(model->RendererFor({}, {})->Render(*camera_, {}, {}).image.cols, 8);
}

TEST_F(OpenSceneModelTest, NobodyKnowsWhereAFieldOfPosesWithoutAScaleLies) {
  const auto model = OpenSceneModel(WriteField({false, {}}));
  EXPECT_THAT(MessageOf<InputError>([&] { model->FindFrame(std::nullopt); }),
              HasSubstr("field.dvn: was trained on poses without a scale"));
}

TEST_F(OpenSceneModelTest, AWarpNeedsPointsOrDepthMaps) {
  EXPECT_TRUE(OpenSceneModel({"warp", {}, camera_, nullptr, {}})->NeedsPoints());
  cv::imwrite((directory_ / "1000000000.png").string(), cv::Mat(6, 8, CV_16UC1, cv::Scalar(3000)));
  const auto maps = OpenDepthMaps({directory_, "ray", 1e-3}, camera_);
  const auto model = OpenSceneModel({"warp", {}, camera_, maps, {}});
  EXPECT_FALSE(model->NeedsPoints());
  EXPECT_EQ(model->Describe(), maps->Describe());
  const ViewSource source{1000000000, cv::Mat(6, 8, CV_8UC1, cv::Scalar(9)), {}};
  EXPECT_NEAR(
      model->RendererFor(source, {})->Render(*camera_, {}, {}).depth.at<float>(3, 4), 3, 1e-4);
}

TEST_F(OpenSceneModelTest, DepthMapsAreFoundByTheStampsOfImages) {
  cv::imwrite((directory_ / "1000000000.png").string(), cv::Mat(6, 8, CV_16UC1, cv::Scalar(3000)));
  const auto maps = OpenDepthMaps({directory_, "ray", 1e-3}, camera_);
  EXPECT_EQ(maps->CountImages({1000000000, 2000000000}, "flight.bag"), 1U);
  EXPECT_TRUE(maps->Find(1000000000));
  EXPECT_FALSE(maps->Find(2000000000));
  EXPECT_THAT(MessageOf<InputError>([&] { maps->CountImages({5}, "flight.bag"); }),
              HasSubstr("of the 1 images of flight.bag"));
  EXPECT_EQ(OpenDepthMaps({}, camera_), nullptr);
}

TEST_F(OpenSceneModelTest, WhatARendererCannotUseIsRefused) {
  EXPECT_THAT(MessageOf<InputError>([] {
                OpenSceneModel({"mesh", {}, nullptr, nullptr, {}});
              }),
              HasSubstr("'mesh': expected one of nerf, warp"));
  EXPECT_THAT(MessageOf<InputError>([] { OpenSceneModel(std::filesystem::path()); }),
              HasSubstr("--model is missing"));
  EXPECT_THAT(MessageOf<InputError>([&] { OpenSceneModel(directory_ / "none.dvn"); }),
              HasSubstr("none.dvn"));
  cv::imwrite((directory_ / "1000000000.png").string(), cv::Mat(6, 8, CV_16UC1, cv::Scalar(3000)));
  const auto maps = OpenDepthMaps({directory_, "ray", 1e-3}, camera_);
  EXPECT_THAT(MessageOf<InputError>([&] {
                OpenSceneModel({"nerf", "x", camera_, maps, {}});
              }),
              HasSubstr("--renderer warp only"));
}

}  // namespace
}  // namespace deja_view
