#include "deja_view/nerf/feature_grid.hpp"
#include "deja_view/nerf/kernels.hpp"
#include "deja_view/nerf/network.hpp"

#include <random>

#include "device_field.cuh"
#include "device_optimizer.cuh"
#include "grids.cuh"
#include "host_system.hpp"
#include <gmock/gmock.h>

namespace deja_view::nerf::internal {
namespace {

using testing::FloatNear;
using testing::Pointwise;

constexpr float kLayerRounding = 1e-5F;

std::vector<float> RandomFloats(std::size_t count, float low, float high, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> uniform(low, high);
  std::vector<float> values(count);
  for (float& value : values) {
    value = uniform(rng);
  }
  return values;
}

void ExpectSameNetwork(std::size_t samples) {
  const Network network({20, 32, 17, 3}, 4);
  const std::vector<float> x =
      RandomFloats(samples * static_cast<std::size_t>(network.row_stride()), -1, 1, 1);
  const std::vector<float> d_out =
      RandomFloats(samples * static_cast<std::size_t>(network.output_stride()), -1, 1, 2);
  Network::Activations activations;
  const float* y = network.Forward(PortableKernels(), x.data(), samples, &activations);
  const std::vector<float> out(y, y + d_out.size());
  std::vector<float> gradient(network.parameters().size(), 0.5F);
  std::vector<float> d_x(x.size());
  network.Backward(PortableKernels(),
                   x.data(),
                   d_out.data(),
                   samples,
                   &activations,
                   gradient.data(),
                   d_x.data());

  DeviceNetwork<HostSystem> device;
  device.Load(network.layers(), network.parameters().data());
  const float* device_y = device.Forward(x.data(), samples);
  EXPECT_THAT(std::vector<float>(device_y, device_y + d_out.size()),
              Pointwise(FloatNear(kLayerRounding), out));
  BackwardRows<HostSystem> scratch;
  std::vector<float> device_gradient(gradient.size(), 0.5F);
  std::vector<float> device_d_x(x.size());
  device.Backward(
      x.data(), d_out.data(), samples, &scratch, device_gradient.data(), device_d_x.data());
  EXPECT_THAT(device_d_x, Pointwise(FloatNear(kLayerRounding), d_x));
  EXPECT_THAT(device_gradient, Pointwise(FloatNear(1e-3F), gradient));
}

TEST(DeviceNetwork, IsTheCpusForwardsAndBackwards) {
  ExpectSameNetwork(1);
  ExpectSameNetwork(37);
  ExpectSameNetwork(kSamplesPerSum);
  ExpectSameNetwork(2 * kSamplesPerSum + 3);
}

TEST(DeviceNetwork, NoSamplesAreNoWork) {
  ExpectSameNetwork(0);
}

/// Random places in a grid with dense and hashed levels of four features.
class DeviceGridTest : public testing::Test {
 protected:
  DeviceGridTest()
      : grid_({4, 4, 10, 4, 60}, {1.0F, 0.7F, 0.4F}, 3),
        x_(RandomFloats(kSamples, 0, 1.0F, 4)),
        y_(RandomFloats(kSamples, 0, 0.7F, 5)),
        z_(RandomFloats(kSamples, 0, 0.4F, 6)) {
    device_.Load({grid_.levels(), grid_.parameters().size()}, grid_.parameters().data());
    // Faces of the box, too.
    x_[0] = y_[0] = z_[0] = 0;
    x_[1] = 1.0F;
    y_[1] = 0.7F;
    z_[1] = 0.4F;
  }

  PlaceArrays places() const { return {x_.data(), y_.data(), z_.data()}; }

  /// What the CPU adds to the entries.
  std::vector<float> CpuGradient(const std::vector<float>& d_rows, std::size_t stride) const {
    std::vector<float> gradient(grid_.parameters().size(), 0.0F);
    std::vector<std::uint8_t> touched(grid_.parameters().size());
    for (std::size_t l = 0; l < grid_.levels().size(); ++l) {
      const GridLevel& level = grid_.levels()[l];
      std::vector<float> d_level;
      for (std::size_t s = 0; s < kSamples; ++s) {
        const auto* row = d_rows.data() + s * stride + 4 * l;
        d_level.insert(d_level.end(), row, row + 4);
      }
      PortableKernels().grid_backward(level,
                                      {x_.data(), y_.data(), z_.data()},
                                      kSamples,
                                      d_level.data(),
                                      gradient.data() + level.offset,
                                      touched.data());
    }
    return gradient;
  }

  static constexpr std::size_t kSamples = 301;
  FeatureGrid grid_;
  std::vector<float> x_, y_, z_;
  DeviceGrid<HostSystem> device_;
};

TEST_F(DeviceGridTest, ReadsWhatTheCpuReads) {
  constexpr std::size_t kStride = 21;
  std::vector<float> expected(kSamples * kStride, 9.0F);
  grid_.Forward(
      PortableKernels(), {x_.data(), y_.data(), z_.data()}, kSamples, kStride, expected.data());
  std::vector<float> rows(kSamples * kStride, 9.0F);
  ForEach<HostSystem>(kSamples * 4, EncodeLevel{device_.view(), places(), rows.data(), kStride});
  FinishRow ends;
  ends.rows = rows.data();
  ends.stride = kStride;
  ends.features = device_.outputs();
  ForEach<HostSystem>(kSamples, ends);
  EXPECT_EQ(rows, expected);
}

// Adam's first step with a rate of 1 and betas of 0 leaves p - g / |g|; so the gradient is looked
// at by its effect on two optimizers.
TEST_F(DeviceGridTest, ScattersWhatTheCpuScatters) {
  constexpr std::size_t kStride = 16;
  const std::vector<float> d_rows = RandomFloats(kSamples * kStride, -1, 1, 8);
  const std::vector<float> expected = CpuGradient(d_rows, kStride);
  std::vector<float> gradient(expected.size(), 0.0F);
  std::vector<std::uint8_t> touched(device_.bricks(), 0);
  const ScatterArrays arrays{
      device_.view(), places(), d_rows.data(), kStride, gradient.data(), touched.data()};
  ForEach<HostSystem>(kSamples * 4, ScatterLevel{arrays});
  EXPECT_THAT(gradient, Pointwise(FloatNear(kLayerRounding), expected));
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    EXPECT_TRUE(gradient[i] == 0 || touched[i / 32] == 1);
  }
}

TEST_F(DeviceGridTest, SortedSumsAreTheCpusToTheBit) {
  constexpr std::size_t kStride = 16;
  const std::vector<float> d_rows = RandomFloats(kSamples * kStride, -1, 1, 8);
  const std::vector<float> expected = CpuGradient(d_rows, kStride);
  std::vector<float> gradient(expected.size(), 0.0F);
  std::vector<std::uint8_t> touched(device_.bricks(), 0);
  const ScatterArrays arrays{
      device_.view(), places(), d_rows.data(), kStride, gradient.data(), touched.data()};
  const std::size_t count = kSamples * 4 * 8;
  std::vector<std::uint32_t> entries(count);
  std::vector<std::uint32_t> items(count);
  std::vector<float> weights(count);
  ForEach<HostSystem>(count / 8, ListCorners{arrays, entries.data(), items.data(), weights.data()});
  SortByKey<HostSystem>(entries.data(), count, items.data());
  ForEach<HostSystem>(count,
                      SumSorted{arrays, entries.data(), items.data(), weights.data(), count});
  EXPECT_EQ(gradient, expected);
}

TEST_F(DeviceGridTest, OnlyTouchedBricksAreUpdated) {
  const std::vector<float> d_rows(16, 1.0F);
  const std::vector<float> before = device_.values.Download();
  DeviceGridOptimizer<HostSystem> optimizer;
  for (const bool deterministic : {false, true}) {
    optimizer.Start(device_, deterministic);
    optimizer.Add(device_, places(), d_rows.data(), 16, 1);
    optimizer.Update({}, &device_);
    const std::vector<float> once = device_.values.Download();
    std::size_t changed = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      changed += once[i] != before[i] ? 1 : 0;
    }
    EXPECT_GT(changed, std::size_t{0});
    EXPECT_LE(changed, std::size_t{4} * 8 * 4);
    // Nothing is left over for the next step; momentum moves what is touched only.
    optimizer.Update({}, &device_);
    EXPECT_EQ(device_.values.Download(), once);
    device_.values.Upload(before);
  }
}

TEST_F(DeviceGridTest, DroppedGradientsChangeNothing) {
  const std::vector<float> d_rows(16, 1.0F);
  const std::vector<float> before = device_.values.Download();
  DeviceGridOptimizer<HostSystem> optimizer;
  optimizer.Start(device_, false);
  optimizer.Add(device_, places(), d_rows.data(), 16, 1);
  optimizer.DropGradient();
  optimizer.Update({}, &device_);
  EXPECT_EQ(device_.values.Download(), before);
  // Nor do they come back with the next ones.
  optimizer.Add(device_, places(), std::vector<float>(16, 0.0F).data(), 16, 1);
  optimizer.Update({}, &device_);
  EXPECT_EQ(device_.values.Download(), before);
}

TEST_F(DeviceGridTest, NoSamplesChangeNothing) {
  const std::vector<float> before = device_.values.Download();
  DeviceGridOptimizer<HostSystem> optimizer;
  optimizer.Start(device_, true);
  optimizer.Add(device_, places(), nullptr, 16, 0);
  optimizer.Update({}, &device_);
  EXPECT_EQ(device_.values.Download(), before);
}

}  // namespace
}  // namespace deja_view::nerf::internal
