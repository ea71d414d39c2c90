#include "device_renderer.hpp"

#include "deja_view/camera/camera_parameters.hpp"
#include "deja_view/nerf/field_renderer.hpp"
#include "deja_view/nerf/trainer.hpp"

#include <cmath>
#include <memory>

#include "host_platform.hpp"
#include "nerf/closed_form.hpp"
#include "nerf/wave_room.hpp"
#include <gtest/gtest.h>

namespace deja_view::nerf::internal {
namespace {

const DeviceChoice kStandIn{&Host(), 0};

/// Within 1/255 and 0.5 % of depth, for 99.9 % of the pixels.
void ExpectSameView(const RenderedView& expected, const RenderedView& found) {
  ASSERT_EQ(found.image.size(), expected.image.size());
  ASSERT_EQ(found.image.type(), expected.image.type());
  const auto pixels = static_cast<double>(expected.depth.total());
  const auto channels = static_cast<std::size_t>(expected.image.channels());
  double differing = 0;
  for (std::size_t i = 0; i < expected.depth.total(); ++i) {
    const float depth = expected.depth.ptr<float>()[i];
    bool differs = std::abs(found.depth.ptr<float>()[i] - depth) > 5e-3F * depth;
    for (std::size_t c = i * channels; c < (i + 1) * channels; ++c) {
      differs = differs || std::abs(found.image.ptr()[c] - expected.image.ptr()[c]) > 1;
    }
    differing += differs ? 1 : 0;
    EXPECT_NEAR(found.opacity.ptr<float>()[i], expected.opacity.ptr<float>()[i], 1e-3F);
    EXPECT_NEAR(found.depth_variance.ptr<float>()[i],
                expected.depth_variance.ptr<float>()[i],
                1e-2F * (expected.depth_variance.ptr<float>()[i] + 0.1F));
  }
  EXPECT_LE(differing, 1e-3 * pixels);
}

std::shared_ptr<RadianceField> TrainedRoom() {
  TrainOptions options = SmallOptions();
  options.field.direction_degree = 1;
  options.field.far_background = true;
  Trainer trainer(options, MakeViews(12), RoomBox());
  for (int i = 0; i < 70; ++i) {
    trainer.Step(i / 70.0);
  }
  return std::make_shared<RadianceField>(std::move(trainer).TakeField());
}

TEST(DeviceRenderer, ShowsWhatTheCpuShows) {
  const auto field = TrainedRoom();
  const FieldRenderer cpu(field);
  const FieldRenderer device(field, kStandIn);
  ViewRenderOptions options;
  options.gain = 0.8F;
  options.bias = 0.05F;
  for (const CameraParameters& parameters :
       {CameraParameters{"PINHOLE", 61, 47, {-0.2, 0.05, 0, 0}, {40, 40, 30, 23}},
        CameraParameters{"KANNALA_BRANDT", 40, 39, {-0.01, 0.01, 0, 0}, {15, 15, 20, 20}},
        CameraParameters{"MEI", 40, 31, {-0.1, 0, 0, 0}, {0.9, 40, 40, 20, 15}},
        CameraParameters{"PINHOLE", 1, 1, {0, 0, 0, 0}, {1, 1, 0, 0}}}) {
    const auto camera = MakeCamera(parameters, "test");
    for (const int i : {2, 9}) {
      ExpectSameView(cpu.Render(*camera, Pose(i), options),
                     device.Render(*camera, Pose(i), options));
    }
  }
}

TEST(DeviceRenderer, ShowsASlabInColourAsTheCpuDoes) {
  const auto field = std::make_shared<RadianceField>(ConstantField(2, 0.3F, 3));
  field->march = MarchOptions();
  field->vignetting.k = {-1, 0.2F, 0};
  const auto camera = MakeCamera({"PINHOLE", 37, 21, {0, 0, 0, 0}, {25, 25, 18, 10}}, "test");
  ViewRenderOptions options;
  for (const bool vignetting : {true, false}) {
    options.vignetting = vignetting;
    ExpectSameView(FieldRenderer(field).Render(*camera, {}, options),
                   FieldRenderer(field, kStandIn).Render(*camera, {}, options));
  }
}

TEST(DeviceRenderer, ShowsNothingOfEmptySpace) {
  const auto field = std::make_shared<RadianceField>(ConstantField(2, 0.3F));
  field->occupancy.SetWords(std::vector<std::uint64_t>(field->occupancy.words().size(), 0));
  const auto camera = MakeCamera({"PINHOLE", 9, 7, {0, 0, 0, 0}, {9, 9, 4, 3}}, "test");
  const RenderedView view = FieldRenderer(field, kStandIn).Render(*camera, {}, {});
  for (std::size_t i = 0; i < view.depth.total(); ++i) {
    EXPECT_EQ(view.image.ptr()[i], 0);
    EXPECT_EQ(view.depth.ptr<float>()[i], 0);
    EXPECT_EQ(view.opacity.ptr<float>()[i], 0);
  }
}

}  // namespace
}  // namespace deja_view::nerf::internal
