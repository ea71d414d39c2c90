#include "deja_view/base/random.hpp"
#include "deja_view/nerf/field_renderer.hpp"
#include "deja_view/nerf/image_metrics.hpp"
#include "deja_view/nerf/trainer.hpp"

#include <cmath>
#include <cstring>
#include <memory>

#include "cpu_worker.hpp"
#include "device_images.cuh"
#include "device_worker.hpp"
#include "host_platform.hpp"
#include "host_system.hpp"
#include "nerf/wave_room.hpp"
#include "plain_field.hpp"
#include "ray_batch.hpp"
#include <gtest/gtest.h>

namespace deja_view::nerf::internal {
namespace {

const DeviceChoice kOnHost{&Host(), 0};

std::vector<TrainingView> ViewsWithPoints(int count) {
  std::vector<TrainingView> views = MakeViews(count);
  for (TrainingView& view : views) {
    view.points = {{3.4F, 5.6F, 1.5F}, {40, 30, 2}, {47.9F, -0.4F, 1}};
  }
  return views;
}

/// What both devices draw for a chunk.
void ExpectSameRays(float depth_weight) {
  TrainOptions options = SmallOptions();
  options.depth_weight = depth_weight;
  options.field.latent_size = 3;
  const std::vector<TrainingView> views = ViewsWithPoints(5);
  RadianceField field(options.field, options.march, RoomBox(), 1, 1);
  field.vignetting.k = {-0.5F, 0.1F, 0.2F};
  const ImageParameters parameters(options, views, &field);
  const RayBatch batch(options, views);
  TrainingSet set;
  set.lenses = {LensOf(*views[0].camera)};
  ImageState state;
  state.vignetting_k = field.vignetting.k;
  state.latents.resize(15);
  for (std::uint32_t v = 0; v < views.size(); ++v) {
    set.images.push_back({views[v].image.ptr(), 48, 36, 1, 0});
    state.gain_bias.push_back({1, 0});
    state.poses.push_back(PlainPoseOf(views[v].T_N_C));
    for (const DepthPoint& point : views[v].points) {
      set.points.push_back({v,
                            std::clamp(static_cast<int>(std::lround(point.u)), 0, 47),
                            std::clamp(static_cast<int>(std::lround(point.v)), 0, 35),
                            point.range / static_cast<float>(field.box.Size())});
    }
  }
  DeviceImages<HostSystem> images(set, options);
  images.Set(state);
  StepPlan plan;
  plan.step = 12;
  plan.depth_share = 0.3F;
  DeviceArray<HostSystem, Ray> rays;
  DeviceArray<HostSystem, RayTarget> targets;
  images.Draw(plan, 100, 700, LayoutOf(field), &rays, &targets);
  std::vector<Ray> expected;
  std::vector<RayTarget> expected_targets;
  for (std::size_t i = 0; i < 700; ++i) {
    const std::size_t number = 100 + i;
    batch.Draw(field, parameters, 12, number / 256, 0.3F, &expected, &expected_targets);
    const Ray& ray = expected[number % 256];
    const RayTarget& target = expected_targets[number % 256];
    EXPECT_EQ(targets.data()[i].view, target.view);
    EXPECT_EQ(targets.data()[i].color, target.color);
    EXPECT_EQ(targets.data()[i].range, target.range);
    EXPECT_EQ(targets.data()[i].backdrop, target.backdrop);
    EXPECT_NEAR(targets.data()[i].vignetting, target.vignetting, 1e-6F);
    EXPECT_EQ(rays.data()[i].jitter, ray.jitter);
    EXPECT_NEAR(rays.data()[i].end, ray.end, 1e-6F);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(rays.data()[i].origin[axis], ray.origin[axis], 1e-6F);
      EXPECT_NEAR(rays.data()[i].direction[axis], ray.direction[axis], 1e-6F);
    }
  }
}

TEST(DrawRay, DrawsTheCpusRays) {
  ExpectSameRays(0.1F);
}

TEST(DrawRay, DrawsNoPointsThatWeighNothing) {
  ExpectSameRays(0);
}

/// Every option that adds something to a step.
TrainOptions RichOptions() {
  TrainOptions options = SmallOptions();
  options.field.direction_degree = 2;
  options.field.latent_size = 2;
  options.field.far_background = true;
  options.field.background = {2, 4, 10, 4, 8};
  options.kernels = "portable";
  options.threads = 1;
  options.warmup_steps = 3;
  options.occupancy_interval = 2;
  return options;
}

float LargestDifference(const FloatArray& a, const FloatArray& b) {
  float largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(a[i] - b[i]));
  }
  return largest;
}

// Step by step: the same rays and samples, and what was learnt from them. Adam turns a rounding of
// a gradient near 0 into a whole step, so that only few entries may differ by more.
void ExpectSameTraining(const TrainOptions& options) {
  Trainer cpu(options, ViewsWithPoints(6), RoomBox());
  Trainer device(options, ViewsWithPoints(6), RoomBox(), kOnHost);
  for (int i = 0; i < 8; ++i) {
    const StepReport expected = cpu.Step(0.1 * i + 0.2);
    const StepReport found = device.Step(0.1 * i + 0.2);
    ASSERT_EQ(found.rays, expected.rays) << i;
    EXPECT_NEAR(static_cast<double>(found.samples),
                static_cast<double>(expected.samples),
                1e-3 * static_cast<double>(expected.samples));
    EXPECT_NEAR(static_cast<double>(found.weighted),
                static_cast<double>(expected.weighted),
                1e-3 * static_cast<double>(expected.weighted));
    EXPECT_NEAR(found.psnr_db, expected.psnr_db, 0.02) << i;
  }
  const RadianceField& a = cpu.field();
  const RadianceField& b = device.field();
  EXPECT_EQ(a.occupancy.words(), b.occupancy.words());
  for (std::size_t v = 0; v < a.exposures.size(); ++v) {
    EXPECT_NEAR(a.exposures[v].gain, b.exposures[v].gain, 1e-3F);
    for (std::size_t i = 0; i < a.exposures[v].latent.size(); ++i) {
      EXPECT_NEAR(a.exposures[v].latent[i], b.exposures[v].latent[i], 1e-3F);
    }
  }
  EXPECT_NEAR(a.vignetting.k[0], b.vignetting.k[0], 1e-3F);
}

TEST(DeviceTraining, TakesTheCpusSteps) {
  ExpectSameTraining(SmallOptions());
}

TEST(DeviceTraining, TakesTheCpusStepsWithAllParts) {
  ExpectSameTraining(RichOptions());
}

TEST(DeviceTraining, TakesTheCpusStepsSorted) {
  TrainOptions options = RichOptions();
  options.deterministic = true;
  ExpectSameTraining(options);
}

// All but few: Adam makes a whole step of a gradient that rounding alone made.
template <typename Values>
void ExpectMostlySame(const Values& a, const Values& b) {
  ASSERT_EQ(a.size(), b.size());
  std::size_t differing = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    differing += std::abs(a.data()[i] - b.data()[i]) > 1e-4F ? 1 : 0;
  }
  EXPECT_LT(static_cast<double>(differing), 2e-3 * static_cast<double>(a.size()));
}

void ExpectSameParameters(const RadianceField& a, const RadianceField& b) {
  ExpectMostlySame(a.geometry.parameters(), b.geometry.parameters());
  ExpectMostlySame(a.appearance.parameters(), b.appearance.parameters());
  ExpectMostlySame(a.background.parameters(), b.background.parameters());
  ExpectMostlySame(a.density.parameters(), b.density.parameters());
  ExpectMostlySame(a.color.parameters(), b.color.parameters());
  ExpectMostlySame(a.background_color.parameters(), b.background_color.parameters());
}

// One step from the same field: the gradients themselves, by what Adam makes of them.
TEST(DeviceTraining, LearnsWhatTheCpuLearnsFromOneStep) {
  TrainOptions options = RichOptions();
  options.grid_learning_rate = 1e-2F;
  Trainer cpu(options, ViewsWithPoints(3), RoomBox());
  Trainer device(options, ViewsWithPoints(3), RoomBox(), kOnHost);
  cpu.Step(0.5);
  device.Step(0.5);
  const RadianceField& a = cpu.field();
  const RadianceField& b = device.field();
  ExpectSameParameters(a, b);
  // The step did something.
  const Trainer fresh(options, ViewsWithPoints(3), RoomBox());
  EXPECT_GT(LargestDifference(b.geometry.parameters(), fresh.field().geometry.parameters()), 1e-3F);
}

/// The same field, images in colour and parameters on both devices. The field's box is small, so
/// that cameras are within and outside, and its entries are large, so that places matter.
class DeviceWorkerTest : public testing::Test {
 protected:
  DeviceWorkerTest()
      : options_(RichOptions()),
        views_(MakeColorViews()),
        field_(MakeField()),
        on_device_(MakeField()),
        parameters_(options_, views_, &field_),
        device_parameters_(options_, views_, &on_device_),
        occupancy_(field_.occupancy.words()),
        cpu_(options_, views_, parameters_, &occupancy_, &field_),
        device_(kOnHost, options_, views_, device_parameters_, occupancy_, &on_device_) {}

  static std::vector<TrainingView> MakeColorViews() {
    std::vector<TrainingView> views = ViewsWithPoints(5);
    for (TrainingView& view : views) {
      cv::Mat color;
      cv::merge(std::vector<cv::Mat>{view.image, 255 - view.image, view.image / 2}, color);
      view.image = color;
    }
    return views;
  }

  RadianceField MakeField() const {
    SceneBox box;
    box.min = {-0.5, -0.6, 0.58};
    box.max = {1.5, 0.7, 1.4};
    RadianceField field(options_.field, options_.march, box, 3, 7);
    Random random(3);
    for (FeatureGrid* grid : {&field.geometry, &field.appearance, &field.background}) {
      for (std::size_t i = 0; i < grid->parameters().size(); ++i) {
        grid->parameters()[i] = random.UniformFloat() - 0.5F;
      }
    }
    field.vignetting.k = {-0.5F, 0.1F, 0.2F};
    for (int v = 0; v < 5; ++v) {
      const auto u = static_cast<float>(v);
      field.exposures.push_back(
          {std::to_string(v), 0, 1 + 0.05F * u, 0.02F * u, {0.3F * (u - 2), 0.1F * (2 - u)}});
    }
    field.occupancy.SetWords(
        std::vector<std::uint64_t>(field.occupancy.words().size(), ~std::uint64_t{0}));
    return field;
  }

  static StepPlan Plan() {
    StepPlan plan;
    plan.step = 9;
    plan.chunks = 3;
    plan.trace = {SmallOptions().march, 1.5F};
    plan.depth_share = 0.3F;
    return plan;
  }

  TrainOptions options_;
  std::vector<TrainingView> views_;
  RadianceField field_, on_device_;
  ImageParameters parameters_, device_parameters_;
  OccupancyUpdate occupancy_;
  CpuWorker cpu_;
  DeviceWorker device_;
};

/// Within 1 % of the largest.
void ExpectSameNumbers(const std::vector<float>& expected, const std::vector<float>& found) {
  ASSERT_EQ(found.size(), expected.size());
  float largest = 0;
  for (const float value : expected) {
    largest = std::max(largest, std::abs(value));
  }
  EXPECT_GT(largest, 0);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_NEAR(found[i], expected[i], 0.01F * largest) << i;
  }
}

/// Numbers of all rays, chunk after chunk.
struct RayNumbers {
  explicit RayNumbers(const std::vector<ImageGradient>& chunks) {
    for (const ImageGradient& chunk : chunks) {
      for (std::size_t ray = 0; ray < chunk.targets.size(); ++ray) {
        off_axis.push_back(chunk.targets[ray].off_axis);
        gain.push_back(chunk.d_exposure[ray].gain);
        bias.push_back(chunk.d_exposure[ray].bias);
      }
      latent.insert(latent.end(), chunk.d_latent.begin(), chunk.d_latent.end());
    }
  }

  std::vector<float> off_axis, gain, bias, latent;
};

TEST_F(DeviceWorkerTest, RaysLeaveTheCpusGradientsForTheirImages) {
  std::vector<ImageGradient> of_cpu;
  std::vector<ImageGradient> of_device;
  const StepSums expected = cpu_.RunRays(Plan(), &of_cpu);
  const StepSums found = device_.RunRays(Plan(), &of_device);
  EXPECT_EQ(found.samples, expected.samples);
  EXPECT_EQ(found.weighted, expected.weighted);
  EXPECT_EQ(found.color_values, expected.color_values);
  EXPECT_NEAR(found.squared_error, expected.squared_error, 1e-4 * expected.squared_error);
  const RayNumbers a(of_cpu);
  const RayNumbers b(of_device);
  ExpectSameNumbers(a.off_axis, b.off_axis);
  ExpectSameNumbers(a.gain, b.gain);
  ExpectSameNumbers(a.bias, b.bias);
  ExpectSameNumbers(a.latent, b.latent);
}

TEST_F(DeviceWorkerTest, FieldsTakeTheSameStepsAtAnyRate) {
  for (const float rate : {0.25F, 0.5F}) {
    std::vector<ImageGradient> unused;
    cpu_.RunRays(Plan(), &unused);
    device_.RunRays(Plan(), &unused);
    cpu_.UpdateField(rate);
    device_.UpdateField(rate);
    device_.Download();
    ExpectSameParameters(field_, on_device_);
  }
}

TEST(DeviceTraining, ReachesTheCpusPsnr) {
  constexpr int kSteps = 80;
  TrainOptions options = SmallOptions();
  options.kernels = "auto";
  std::vector<double> psnr_db;
  for (const DeviceChoice& device : {DeviceChoice(), kOnHost}) {
    Trainer trainer(options, MakeViews(25), RoomBox(), device);
    for (int i = 0; i < kSteps; ++i) {
      trainer.Step(static_cast<double>(i) / kSteps);
    }
    const auto field = std::make_shared<RadianceField>(std::move(trainer).TakeField());
    const FieldRenderer renderer(field, device);
    double sum = 0;
    for (const int i : {3, 10, 17, 24}) {
      const Rigid3 T_N_C = Interpolate(Pose(i), Pose(i + 1), 0.5);
      const TrainingView real = MakeView(SmallCamera(), T_N_C, 0.95F);
      sum += Psnr(real.image, renderer.Render(*real.camera, T_N_C, {}).image);
    }
    psnr_db.push_back(sum / 4);
  }
  EXPECT_GT(psnr_db[0], 18.0);
  EXPECT_NEAR(psnr_db[1], psnr_db[0], 0.2);
}

TEST(DeviceTraining, IsRepeatableToTheBitWhenSorted) {
  TrainOptions options = SmallOptions();
  options.deterministic = true;
  std::vector<RadianceField> fields;
  for (int run = 0; run < 2; ++run) {
    Trainer trainer(options, ViewsWithPoints(4), RoomBox(), kOnHost);
    for (int i = 0; i < 5; ++i) {
      trainer.Step(0.2 * i);
    }
    fields.push_back(std::move(trainer).TakeField());
  }
  EXPECT_EQ(LargestDifference(fields[0].geometry.parameters(), fields[1].geometry.parameters()), 0);
  EXPECT_EQ(fields[0].color.parameters(), fields[1].color.parameters());
}

// A field goes from one device to the other, and on.
TEST(DeviceTraining, GoesOnWithTheOtherDevicesField) {
  TrainOptions options = SmallOptions();
  options.warmup_steps = 10;
  DeviceChoice devices[2] = {DeviceChoice(), kOnHost};
  for (int first = 0; first < 2; ++first) {
    Trainer begun(options, MakeViews(8), RoomBox(), devices[first]);
    for (int i = 0; i < 30; ++i) {
      begun.Step(0.01 * i);
    }
    Trainer resumed(options, MakeViews(8), std::move(begun).TakeField(), devices[1 - first]);
    const double psnr_db = resumed.Step(0.3).psnr_db;
    double later_db = 0;
    for (int i = 1; i < 30; ++i) {
      later_db = resumed.Step(0.3 + 0.01 * i).psnr_db;
    }
    EXPECT_GT(psnr_db, 10.0);
    EXPECT_GT(later_db, psnr_db);
  }
}

}  // namespace
}  // namespace deja_view::nerf::internal
