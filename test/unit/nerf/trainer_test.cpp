#include "deja_view/nerf/trainer.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/nerf/field_renderer.hpp"
#include "deja_view/nerf/image_metrics.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "wave_room.hpp"
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view::nerf {
namespace {

bool SameBits(const FloatArray& a, const FloatArray& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

TEST(Trainer, LearnsARoomAndItsExposures) {
  constexpr int kSteps = 240;
  TrainOptions options = SmallOptions();
  options.exposure_learning_rate = 5e-3F;
  options.target_samples = 1 << 16;
  Trainer trainer(options, MakeViews(150), RoomBox());
  for (int i = 0; i < kSteps; ++i) {
    trainer.Step(static_cast<double>(i) / kSteps);
  }
  const auto field = std::make_shared<RadianceField>(std::move(trainer).TakeField());
  // Even images are darker by 10 %; so short a training finds part of it.
  EXPECT_LT(field->exposures[0].gain / field->exposures[1].gain, 0.98F);
  EXPECT_LT(field->occupancy.CountOccupied(), field->occupancy.cell_count() * 3 / 4);
  const FieldRenderer renderer(field);
  // Between two training poses.
  const Rigid3 T_N_C = Interpolate(Pose(10), Pose(11), 0.5);
  const TrainingView real = MakeView(SmallCamera(), T_N_C, 1.0F);
  const Exposure& exposure = field->exposures[11];
  const RenderedView view = renderer.Render(*real.camera, T_N_C, {exposure.gain, exposure.bias, 0});
  EXPECT_GT(Psnr(real.image, view.image), 23.0);
}

TEST(Trainer, ThreadsDoNotChangeABit) {
  TrainOptions options = SmallOptions();
  options.warmup_steps = 4;
  options.occupancy_interval = 3;
  std::vector<RadianceField> fields;
  for (const int threads : {1, 2, 3}) {
    options.threads = threads;
    Trainer trainer(options, MakeViews(6), RoomBox());
    for (int i = 0; i < 10; ++i) {
      trainer.Step(0.1 * i);
    }
    fields.push_back(std::move(trainer).TakeField());
  }
  for (std::size_t i = 1; i < fields.size(); ++i) {
    EXPECT_TRUE(SameBits(fields[0].geometry.parameters(), fields[i].geometry.parameters()));
    EXPECT_TRUE(SameBits(fields[0].appearance.parameters(), fields[i].appearance.parameters()));
    EXPECT_EQ(fields[0].color.parameters(), fields[i].color.parameters());
    EXPECT_EQ(fields[0].density.parameters(), fields[i].density.parameters());
    EXPECT_EQ(fields[0].occupancy.words(), fields[i].occupancy.words());
  }
}

TEST(Trainer, DepthPointsDrawWeightToThem) {
  std::vector<TrainingView> views = MakeViews(4);
  for (TrainingView& view : views) {
    view.image.setTo(128);  // without texture, only the points tell where the walls are
    for (int i = 0; i < 200; ++i) {
      view.points.push_back(WallPoint(view, {i * 7 % 48, i * 11 % 36}));
    }
  }
  const std::vector<TrainingView> kept = views;
  TrainOptions options = SmallOptions();
  options.depth_share = 0.5F;
  options.depth_weight = 1;
  Trainer trainer(options, std::move(views), RoomBox());
  for (int i = 0; i < 200; ++i) {
    trainer.Step(i / 200.0);
  }
  const FieldRenderer renderer(std::make_shared<RadianceField>(std::move(trainer).TakeField()));
  const RenderedView view = renderer.Render(*kept[0].camera, kept[0].T_N_C, {});
  std::vector<float> errors;
  for (const DepthPoint& point : kept[0].points) {
    const cv::Point pixel(static_cast<int>(point.u), static_cast<int>(point.v));
    errors.push_back(std::abs(view.depth.at<float>(pixel) - point.range) / point.range);
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.06F);
}

TEST(Trainer, DarkSurfacesAreNotMistakenForNothing) {
  double opacity[2] = {};
  for (const bool opaque : {false, true}) {
    std::vector<TrainingView> views = MakeViews(8);
    for (TrainingView& view : views) {
      view.image.setTo(0);
    }
    TrainOptions options = SmallOptions();
    options.opaque = opaque;
    options.exposure = false;
    Trainer trainer(options, views, RoomBox());
    for (int i = 0; i < 100; ++i) {
      trainer.Step(i / 100.0);
    }
    const FieldRenderer renderer(std::make_shared<RadianceField>(std::move(trainer).TakeField()));
    const RenderedView view = renderer.Render(*views[0].camera, views[0].T_N_C, {});
    opacity[opaque ? 1 : 0] = cv::mean(view.opacity)[0];
    EXPECT_LT(cv::mean(view.image)[0], 20) << "dark, as it is";
  }
  EXPECT_LT(opacity[0], 0.7);
  EXPECT_GT(opacity[1], 0.95);
}

TEST(Trainer, RefusesViewsItCantTrainOn) {
  EXPECT_THROW(Trainer(SmallOptions(), {}, RoomBox()), InputError);
  std::vector<TrainingView> views = MakeViews(2);
  views[1].image = cv::Mat(5, 5, CV_8UC1);
  EXPECT_THROW(Trainer(SmallOptions(), views, RoomBox()), InputError);
  views = MakeViews(2);
  views[1].T_N_C.t.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Trainer(SmallOptions(), views, RoomBox()), InputError);
  TrainOptions options = SmallOptions();
  options.kernels = "none";
  EXPECT_THROW(Trainer(options, MakeViews(2), RoomBox()), InputError);
  options = SmallOptions();
  options.patch_px = 0;
  EXPECT_THROW(Trainer(options, MakeViews(2), RoomBox()), CheckError);
}

TEST(BoxAround, HoldsCamerasAndPoints) {
  std::vector<TrainingView> views = MakeViews(3);
  views[0].points.push_back({23.5F, 17.5F, 10.0F});
  const SceneBox box = BoxAround(views, 0.1);
  EXPECT_GT(box.Size(), 10);
  for (const TrainingView& view : views) {
    EXPECT_TRUE((view.T_N_C.t.array() > box.min.array()).all());
    EXPECT_TRUE((view.T_N_C.t.array() < box.max.array()).all());
  }
  views.resize(1);
  views[0].points.clear();
  EXPECT_THROW(BoxAround(views, 0.1), InputError);
}

// Ranges of some pixels of each view, as a VIO would know them.
void AddPoints(std::vector<TrainingView>* views) {
  for (TrainingView& view : *views) {
    for (int i = 0; i < 12; ++i) {
      view.points.push_back(WallPoint(view, {4 + i * 37 % 40, 3 + i * 23 % 30}));
    }
  }
}

double MeanDepthError(const std::shared_ptr<const RadianceField>& field,
                      const std::vector<TrainingView>& views) {
  const FieldRenderer renderer(field);
  double sum = 0;
  int count = 0;
  for (std::size_t v = 0; v < views.size(); v += 10) {
    const RenderedView view = renderer.Render(*views[v].camera, views[v].T_N_C, {});
    for (const DepthPoint& point : views[v].points) {
      const float depth =
          view.depth.at<float>(static_cast<int>(point.v), static_cast<int>(point.u));
      sum += static_cast<double>(std::abs(depth - point.range) / point.range);
      ++count;
    }
  }
  return sum / count;
}

TEST(Trainer, DepthPointsFindTheWallsSooner) {
  std::vector<TrainingView> views = MakeViews(60);
  std::vector<TrainingView> with_points = views;
  AddPoints(&with_points);
  const auto train = [](const std::vector<TrainingView>& from) {
    Trainer trainer(SmallOptions(), from, RoomBox());
    for (int i = 0; i < 90; ++i) {
      trainer.Step(i / 90.0);
    }
    return std::make_shared<const RadianceField>(std::move(trainer).TakeField());
  };
  const double without = MeanDepthError(train(views), with_points);
  const auto field = train(with_points);
  EXPECT_LT(MeanDepthError(field, with_points), 0.6 * without);
  // The middle of the room has been seen through.
  const auto middle = static_cast<int>(0.5F * field->occupancy.scale());
  EXPECT_FALSE(field->occupancy.IsOccupied(field->occupancy.Index(middle, middle, middle)));
}

TEST(Trainer, FindsTheVignetting) {
  constexpr double kFalloff = -1.2;
  std::vector<TrainingView> views = MakeViews(80);
  for (TrainingView& view : views) {
    for (int y = 0; y < view.image.rows; ++y) {
      for (int x = 0; x < view.image.cols; ++x) {
        const double s = 1 - view.camera->Unproject({x, y}).z();
        auto& pixel = view.image.at<std::uint8_t>(y, x);
        pixel = static_cast<std::uint8_t>(pixel * std::exp(kFalloff * s));
      }
    }
  }
  TrainOptions options = SmallOptions();
  options.exposure_learning_rate = 1e-2F;
  options.target_samples = 1 << 15;
  Trainer trainer(options, views, RoomBox());
  for (int i = 0; i < 200; ++i) {
    trainer.Step(i / 200.0);
  }
  const double s = 1 - SmallCamera()->Unproject({0, 0}).z();
  const double at_corner =
      static_cast<double>(trainer.field().vignetting.At(static_cast<float>(s)));
  EXPECT_NEAR(at_corner, std::exp(kFalloff * s), 0.08);
  options.vignetting = false;
  Trainer without(options, views, RoomBox());
  without.Step(0);
  EXPECT_EQ(without.field().vignetting.At(0.5F), 1);
}

TEST(Trainer, GoesOnWithAFieldThatWasTrainedBefore) {
  const TrainOptions options = SmallOptions();
  Trainer first(options, MakeViews(40), RoomBox());
  for (int i = 0; i < 120; ++i) {
    first.Step(0.5 * i / 120.0);
  }
  RadianceField half = std::move(first).TakeField();
  EXPECT_NEAR(half.progress, 0.5F, 0.01F);
  const float gain = half.exposures[3].gain;
  Trainer second(options, MakeViews(40), std::move(half));
  EXPECT_EQ(second.field().exposures[3].gain, gain);
  EXPECT_EQ(second.field().exposures.size(), std::size_t{40});
  double early = 0;
  for (int i = 0; i < 10; ++i) {
    early += second.Step(0.5).psnr_db / 10;
  }
  // A new field starts at 14 dB.
  EXPECT_GT(early, 19);
  for (int i = 0; i < 100; ++i) {
    second.Step(0.5 + 0.5 * i / 100.0);
  }
  double late = 0;
  for (int i = 0; i < 10; ++i) {
    late += second.Step(1).psnr_db / 10;
  }
  EXPECT_GT(late, early);
  EXPECT_EQ(second.field().progress, 1);
}

TEST(Trainer, RefusesToGoOnWithOtherChannels) {
  RadianceField field(SmallOptions().field, SmallOptions().march, RoomBox(), 3, 1);
  EXPECT_THROW(Trainer(SmallOptions(), MakeViews(2), std::move(field)), InputError);
}

TEST(BoxAround, LeavesOutWildPoints) {
  std::vector<TrainingView> views = MakeViews(40);
  AddPoints(&views);
  const SceneBox box = BoxAround(views, 0.01);
  EXPECT_NEAR(box.max.x(), kHalfRoom, 0.1);
  views[7].points.push_back({20, 20, 1000});
  EXPECT_NEAR(BoxAround(views, 0.01).Size(), box.Size(), 0.1);
}

}  // namespace
}  // namespace deja_view::nerf
