#include "deja_view/nerf/kernels.hpp"

#include "deja_view/base/check.hpp"

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace deja_view::nerf {
namespace {

std::vector<float> RandomFloats(std::size_t count, float low, float high, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> uniform(low, high);
  std::vector<float> values(count);
  for (float& value : values) {
    value = uniform(rng);
  }
  return values;
}

GridLevel MakeLevel(bool hashed, int features) {
  GridLevel level;
  level.scale = 9.7F;  // 10 cells, 6 bricks per axis
  level.features = features;
  level.hashed = hashed;
  level.bricks = hashed ? 64 : 6 * 6 * 6;
  level.mask = hashed ? 63 : 0;
  level.stride_y = 6;
  level.stride_z = 36;
  return level;
}

// Sizes about those of vectors and blocks, odd ones among them.
constexpr std::size_t kCounts[] = {0, 1, 2, 7, 8, 15, 16, 17, 31, 63, 64, 65, 131};

void ExpectNear(const std::vector<float>& a, const std::vector<float>& b, float tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_NEAR(a[i], b[i], tolerance * (1 + std::abs(b[i]))) << "at " << i;
  }
}

class KernelsTest : public testing::TestWithParam<const Kernels*> {
 protected:
  const Kernels& fast() const { return *GetParam(); }
  const Kernels& reference() const { return PortableKernels(); }
};

TEST_P(KernelsTest, GridForwardAgreesWithReference) {
  for (const bool hashed : {false, true}) {
    for (const int features : {2, 4}) {
      const GridLevel level = MakeLevel(hashed, features);
      const std::vector<float> table = RandomFloats(
          std::size_t{8} * level.bricks * static_cast<std::size_t>(features), -1, 1, 1);
      for (const std::size_t count : kCounts) {
        const std::vector<float> p = RandomFloats(3 * count, 0, 1, 2);
        const Positions positions{p.data(), p.data() + count, p.data() + 2 * count};
        constexpr std::size_t kStride = 7;
        std::vector<float> expected(count * kStride, 9.0F);
        std::vector<float> found(count * kStride, 9.0F);
        reference().grid_forward(level, table.data(), positions, count, expected.data(), kStride);
        fast().grid_forward(level, table.data(), positions, count, found.data(), kStride);
        ExpectNear(found, expected, 1e-5F);
      }
    }
  }
}

TEST_P(KernelsTest, GridBackwardAgreesWithReference) {
  for (const bool hashed : {false, true}) {
    for (const int features : {2, 4}) {
      const GridLevel level = MakeLevel(hashed, features);
      const std::size_t size = std::size_t{8} * level.bricks * static_cast<std::size_t>(features);
      for (const std::size_t count : kCounts) {
        const std::vector<float> p = RandomFloats(3 * count, 0, 1, 3);
        const Positions positions{p.data(), p.data() + count, p.data() + 2 * count};
        const std::vector<float> d =
            RandomFloats(count * static_cast<std::size_t>(features), -1, 1, 4);
        std::vector<float> expected(size, 0.5F);
        std::vector<float> found(size, 0.5F);
        std::vector<std::uint8_t> expected_touched(level.bricks, 0);
        std::vector<std::uint8_t> found_touched(level.bricks, 0);
        reference().grid_backward(
            level, positions, count, d.data(), expected.data(), expected_touched.data());
        fast().grid_backward(level, positions, count, d.data(), found.data(), found_touched.data());
        ExpectNear(found, expected, 1e-5F);
        EXPECT_EQ(found_touched, expected_touched);
      }
    }
  }
}

TEST_P(KernelsTest, LayersAgreeWithReference) {
  for (const LayerShape shape : {LayerShape{16, 16}, LayerShape{32, 48}, LayerShape{48, 32}}) {
    const auto inputs = static_cast<std::size_t>(shape.inputs);
    const auto outputs = static_cast<std::size_t>(shape.outputs);
    const std::vector<float> weights = RandomFloats(inputs * outputs, -1, 1, 5);
    const std::vector<float> bias = RandomFloats(outputs, -1, 1, 6);
    for (const std::size_t count : kCounts) {
      const std::vector<float> x = RandomFloats(count * inputs, -1, 1, 7);
      for (const bool relu : {false, true}) {
        std::vector<float> expected(count * outputs, NAN);
        std::vector<float> found(count * outputs, NAN);
        const float* b = relu ? bias.data() : nullptr;
        reference().layer_forward(shape, weights.data(), b, x.data(), count, relu, expected.data());
        fast().layer_forward(shape, weights.data(), b, x.data(), count, relu, found.data());
        ExpectNear(found, expected, 1e-5F);
      }
      const std::vector<float> d_y = RandomFloats(count * outputs, -1, 1, 8);
      std::vector<float> expected(inputs * outputs, 0.25F);
      std::vector<float> found = expected;
      std::vector<float> expected_bias(outputs, 0.5F);
      std::vector<float> found_bias = expected_bias;
      reference().layer_gradient(
          shape, x.data(), d_y.data(), count, expected.data(), expected_bias.data());
      fast().layer_gradient(shape, x.data(), d_y.data(), count, found.data(), found_bias.data());
      ExpectNear(found, expected, 1e-5F);
      ExpectNear(found_bias, expected_bias, 1e-5F);
    }
  }
}

TEST_P(KernelsTest, AdamAgreesWithReference) {
  constexpr std::size_t kCount = 48;
  AdamStep step;
  step.epsilon = 1e-2F;
  step.decay = 3;
  std::vector<float> expected = RandomFloats(kCount, -1, 1, 9);
  std::vector<float> expected_first(kCount, 0.0F);
  std::vector<float> expected_second(kCount, 0.0F);
  std::vector<float> found = expected;
  std::vector<float> first = expected_first;
  std::vector<float> second = expected_second;
  for (unsigned i = 0; i < 5; ++i) {
    std::vector<float> gradient = RandomFloats(kCount, -1, 1, 10 + i);
    gradient[3] = 0;
    std::vector<float> copy = gradient;
    reference().adam(
        step, kCount, expected.data(), copy.data(), expected_first.data(), expected_second.data());
    fast().adam(step, kCount, found.data(), gradient.data(), first.data(), second.data());
    EXPECT_EQ(gradient, std::vector<float>(kCount, 0.0F));
  }
  ExpectNear(found, expected, 1e-5F);
  ExpectNear(first, expected_first, 1e-5F);
  ExpectNear(second, expected_second, 1e-5F);
}

TEST_P(KernelsTest, ElementwiseFunctionsAgreeWithReference) {
  for (const std::size_t count : kCounts) {
    std::vector<float> raw = RandomFloats(count, -20, 20, 20);
    const std::vector<float> dt = RandomFloats(count, 0, 0.01F, 21);
    std::vector<float> a(count), b(count), c(count), d(count);
    reference().density(raw.data(), dt.data(), count, a.data(), b.data());
    fast().density(raw.data(), dt.data(), count, c.data(), d.data());
    ExpectNear(c, a, 1e-5F);
    ExpectNear(d, b, 1e-5F);
    reference().sigmoid(raw.data(), count, a.data());
    fast().sigmoid(raw.data(), count, raw.data());  // in place
    ExpectNear(raw, a, 1e-5F);
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         KernelsTest,
                         testing::ValuesIn(AvailableKernels()),
                         [](const auto& test) { return std::string(test.param->name); });

// What two features are at a corner.
std::array<float, 2> AtCorner(const GridLevel& level,
                              const std::vector<float>& table,
                              const std::array<float, 3>& corner) {
  std::array<float, 3> p{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    p[axis] = corner[axis] / level.scale + 1e-6F;
  }
  std::array<float, 2> out{};
  PortableKernels().grid_forward(level, table.data(), {&p[0], &p[1], &p[2]}, 1, out.data(), 2);
  return out;
}

TEST(Kernels, DenseEntriesAreWhereTheFormulaSays) {
  const GridLevel level = MakeLevel(false, 2);
  std::vector<float> table(std::size_t{8} * level.bricks * 2, 0.0F);
  // Corner (3, 4, 5): brick (1, 2, 2), place 1 + 2*0 + 4*1 = 5.
  const std::size_t entry = 8 * (1 + 2 * 6 + 2 * 36) + 5;
  table[2 * entry] = 1;
  table[2 * entry + 1] = -2;
  const std::array<float, 2> out = AtCorner(level, table, {3, 4, 5});
  EXPECT_NEAR(out[0], 1, 1e-3F);
  EXPECT_NEAR(out[1], -2, 1e-3F);
}

TEST(Kernels, HashedEntriesAreWhereTheFormulaSays) {
  const GridLevel level = MakeLevel(true, 2);
  std::vector<float> table(std::size_t{8} * level.bricks * 2, 0.0F);
  // Corner (2, 6, 3): brick (1, 3, 1), place 0 + 0 + 4 = 4.
  const std::uint32_t brick = (1U ^ 3U * 2654435761U ^ 805459861U) & 63U;
  table[2 * (8 * brick + 4)] = 3;
  const std::array<float, 2> out = AtCorner(level, table, {2, 6, 3});
  EXPECT_NEAR(out[0], 3, 3e-3F);
}

TEST(Kernels, AreFoundByName) {
  EXPECT_EQ(&FindKernels("portable"), &PortableKernels());
  EXPECT_EQ(&FindKernels("auto"), AvailableKernels().front());
  EXPECT_THROW(FindKernels("avx1024"), InputError);
}

}  // namespace
}  // namespace deja_view::nerf
