#include "device_tracer.cuh"

#include "deja_view/nerf/kernels.hpp"

#include <cmath>
#include <random>

#include "device_occupancy.cuh"
#include "host_system.hpp"
#include "nerf/closed_form.hpp"
#include "occupancy_update.hpp"
#include "plain_field.hpp"
#include "ray_tracer.hpp"
#include <gmock/gmock.h>

namespace deja_view::nerf::internal {
namespace {

using testing::FloatNear;
using testing::Pointwise;

std::vector<Ray> RandomRays(const RadianceField& field, std::size_t count) {
  std::mt19937 rng(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d origin(4 * uniform(rng), 3 * uniform(rng), 2 * uniform(rng));
    const Eigen::Vector3d direction(uniform(rng), uniform(rng), uniform(rng));
    rays.push_back(MakeRay(field, origin, direction.normalized(), i % 2 == 0 ? 0.5F : 0.1F));
  }
  return rays;
}

template <typename T>
std::vector<T> Values(const DeviceArray<HostSystem, T>& array) {
  return array.Download();
}

void ExpectSameTrace(const RadianceField& field, const std::vector<Ray>& rays) {
  const TraceOptions options{field.march, 1.5F};
  RayTracer cpu(field, PortableKernels());
  Trace expected;
  cpu.Run(rays, options, &expected);
  DeviceField<HostSystem> device_field;
  device_field.Load(LayoutOf(field), ArraysOf(field));
  DeviceTracer<HostSystem> tracer;
  tracer.rays.Upload(rays);
  tracer.Run(options, &device_field);
  EXPECT_EQ(tracer.CountEvaluated(), expected.evaluated);
  ASSERT_EQ(Values(tracer.ray_begin), expected.ray_begin);
  EXPECT_EQ(Values(tracer.ray_of), expected.ray);
  constexpr float kRounding = 1e-6F;
  EXPECT_THAT(Values(tracer.t), Pointwise(FloatNear(kRounding), expected.t));
  EXPECT_THAT(Values(tracer.dt), Pointwise(FloatNear(kRounding), expected.dt));
  EXPECT_THAT(Values(tracer.weight), Pointwise(FloatNear(kRounding), expected.weight));
  EXPECT_THAT(Values(tracer.after), Pointwise(FloatNear(kRounding), expected.after));
  EXPECT_THAT(Values(tracer.x), Pointwise(FloatNear(kRounding), expected.x));
  EXPECT_THAT(Values(tracer.y), Pointwise(FloatNear(kRounding), expected.y));
  EXPECT_THAT(Values(tracer.z), Pointwise(FloatNear(kRounding), expected.z));
  EXPECT_THAT(Values(tracer.color), Pointwise(FloatNear(1e-5F), expected.color));
  EXPECT_THAT(Values(tracer.transmittance),
              Pointwise(FloatNear(kRounding), expected.transmittance));
  EXPECT_THAT(Values(tracer.background), Pointwise(FloatNear(1e-5F), expected.background));
}

/// A random field with every part that there is, and matter in some cells.
RadianceField RichField(int channels) {
  FieldOptions options = SmallFieldOptions();
  options.direction_degree = 3;
  options.far_background = true;
  options.background = {2, 4, 10, 4, 8};
  options.latent_size = 5;
  options.color_hidden_layers = 2;
  MarchOptions march;
  march.max_samples = 61;
  march.min_transmittance = 0.05F;
  SceneBox box = ConstantField(1, 0.5F).box;
  box.max -= Eigen::Vector3d(0, 0.1, 0.2);  // its last cells reach beyond it
  RadianceField field(options, march, box, channels, 21);
  field.density.OutputBias(0) = 2;
  std::mt19937 rng(5);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (FeatureGrid* grid : {&field.geometry, &field.appearance, &field.background}) {
    for (std::size_t i = 0; i < grid->parameters().size(); ++i) {
      grid->parameters()[i] = uniform(rng);
    }
  }
  std::vector<std::uint64_t> words(field.occupancy.words().size(), 0);
  for (std::size_t i = 0; i < words.size(); i += 5) {
    words[i] = rng();
  }
  field.occupancy.SetWords(words);
  return field;
}

TEST(DeviceTracer, FindsTheCpusSamples) {
  for (const int channels : {1, 3}) {
    const RadianceField field = RichField(channels);
    std::vector<Ray> rays = RandomRays(field, 257);
    const std::vector<float> latent = {0.3F, -0.2F, 1, 0, -1};
    for (std::size_t i = 0; i < rays.size(); i += 2) {
      rays[i].latent = latent.data();
    }
    ExpectSameTrace(field, rays);
  }
}

TEST(DeviceTracer, FindsTheCpusSamplesInFog) {
  RadianceField field = ConstantField(2, 0.4F);
  field.march.min_weight = 1e-3F;
  field.march.min_transmittance = 0.01F;
  field.march.max_samples = 37;
  ExpectSameTrace(field, RandomRays(field, 100));
}

TEST(DeviceTracer, StopsInTheDarkAsTheCpuDoes) {
  RadianceField field = ConstantField(30, 0.4F);
  field.march.min_transmittance = 0.05F;
  field.march.max_samples = 64;
  ExpectSameTrace(field, RandomRays(field, 100));
}

TEST(DeviceTracer, ManyFeaturesTakeTheLongWay) {
  FieldOptions options = SmallFieldOptions();
  options.geometry = {7, 4, 10, 4, 60};
  const RadianceField field(options, {}, ConstantField(1, 0.5F).box, 1, 2);
  ASSERT_GT(field.density.row_stride(), 16);
  ExpectSameTrace(field, RandomRays(field, 40));
}

TEST(DeviceTracer, NoRaysAndEmptySpaceGiveNoSamples) {
  RadianceField field = ConstantField(2, 0.4F);
  field.march.max_samples = 64;
  ExpectSameTrace(field, {});
  field.occupancy.SetWords(std::vector<std::uint64_t>(field.occupancy.words().size(), 0));
  ExpectSameTrace(field, RandomRays(field, 33));
}

TEST(DeviceTracer, SlabOfConstantDensityDimsAsTheExponential) {
  constexpr double kSigma = 0.7;
  const RadianceField field = ConstantField(kSigma, 0.4F);
  DeviceField<HostSystem> device_field;
  device_field.Load(LayoutOf(field), ArraysOf(field));
  DeviceTracer<HostSystem> tracer;
  tracer.rays.Upload({MakeRay(field, {-5, 0.3, 0.2}, {1, 0, 0}, 0.5F)});
  tracer.Run({field.march, 1.0F}, &device_field);
  EXPECT_NEAR(tracer.transmittance.data()[0], std::exp(-4 * kSigma), 1e-4);
}

void ExpectSameCells(const RadianceField& field, const DeviceField<HostSystem>& device) {
  EXPECT_EQ(Values(device.words), field.occupancy.words());
  const std::vector<std::uint8_t> leaps = Values(device.leaps);
  ASSERT_EQ(leaps.size(), field.occupancy.words().size());
  for (std::size_t block = 0; block < leaps.size(); ++block) {
    ASSERT_EQ(leaps[block], field.occupancy.leap(block)) << block;
  }
}

TEST(DeviceOccupancy, KeepsTheCpusCells) {
  RadianceField field = RichField(1);
  TrainOptions options;
  options.occupancy_threshold = 0.9F;
  options.march.min_step = 0.05F;
  // All but two cells of every second block.
  std::vector<std::uint64_t> open(field.occupancy.words().size(), 0);
  for (std::size_t i = 0; i < open.size(); i += 2) {
    open[i] = ~std::uint64_t{3};
  }
  OccupancyUpdate cpu(open);
  field.occupancy.SetWords(open);
  DeviceField<HostSystem> device_field;
  device_field.Load(LayoutOf(field), ArraysOf(field));
  DeviceOccupancy<HostSystem> device(options, open);
  for (std::uint64_t round = 0; round < 4; ++round) {
    cpu.Run(PortableKernels(), options, round, round == 0, &field);
    device.Run(round, round == 0, &device_field);
    ExpectSameCells(field, device_field);
  }
  EXPECT_GT(field.occupancy.CountOccupied(), std::size_t{0});
  EXPECT_LT(field.occupancy.CountOccupied(), field.occupancy.cell_count() / 2);
}

// Matter that is no longer there is forgotten cell by cell, as the maximum of each decays.
TEST(DeviceOccupancy, ForgetsTheCpusCells) {
  RadianceField field = RichField(1);
  TrainOptions options;
  options.occupancy_threshold = 0.15F;
  options.march.min_step = 0.05F;
  const std::vector<std::uint64_t> open(field.occupancy.words().size(), ~std::uint64_t{0});
  field.occupancy.SetWords(open);
  OccupancyUpdate cpu(open);
  DeviceOccupancy<HostSystem> device(options, open);
  DeviceField<HostSystem> device_field;
  for (std::uint64_t round = 0; round < 6; ++round) {
    field.density.OutputBias(0) = round < 2 ? 2 : -5;
    device_field.Load(LayoutOf(field), ArraysOf(field));
    cpu.Run(PortableKernels(), options, round, round == 0, &field);
    device.Run(round, round == 0, &device_field);
    ExpectSameCells(field, device_field);
  }
  EXPECT_GT(field.occupancy.CountOccupied(), std::size_t{0});
  EXPECT_LT(field.occupancy.CountOccupied(), field.occupancy.cell_count());
}

TEST(DeviceOccupancy, LeapsOverWhatWasFoundEmpty) {
  RadianceField field = RichField(1);
  for (std::size_t i = 0; i < field.geometry.parameters().size(); ++i) {
    field.geometry.parameters()[i] *= 8;
  }
  const std::vector<std::uint64_t> open(field.occupancy.words().size(), ~std::uint64_t{0});
  field.occupancy.SetWords(open);
  OccupancyUpdate cpu(open);
  DeviceOccupancy<HostSystem> device(TrainOptions(), open);
  DeviceField<HostSystem> device_field;
  device_field.Load(LayoutOf(field), ArraysOf(field));
  for (std::uint64_t round = 0; round < 3; ++round) {
    cpu.Run(PortableKernels(), TrainOptions(), round, true, &field);
    device.Run(round, true, &device_field);
    ExpectSameCells(field, device_field);
  }
  EXPECT_THAT(Values(device_field.leaps), testing::Contains(testing::Gt(0)));
}

TEST(DeviceOccupancy, LeapsReachAsFarAsTheCpus) {
  FieldOptions options = SmallFieldOptions();
  options.occupancy_resolution = 128;
  RadianceField field(options, {}, ConstantField(1, 0.5F).box, 1, 2);
  std::vector<std::uint64_t> words(field.occupancy.words().size(), 0);
  words[0] = 1;
  words[words.size() / 2 + 5] = 1;
  field.occupancy.SetWords(words);
  DeviceField<HostSystem> device_field;
  device_field.Load(LayoutOf(field), ArraysOf(field));
  ExpectSameCells(field, device_field);
}

}  // namespace
}  // namespace deja_view::nerf::internal
