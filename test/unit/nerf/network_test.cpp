#include "deja_view/nerf/network.hpp"

#include "deja_view/nerf/kernels.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace deja_view::nerf {
namespace {

// loss = Sum_s Sum_o (o + 1) out[s][o], so that d_out is known.
double Loss(const Network& network, const std::vector<float>& x, std::size_t count, int outputs) {
  Network::Activations activations;
  const float* out = network.Forward(PortableKernels(), x.data(), count, &activations);
  double loss = 0;
  for (std::size_t s = 0; s < count; ++s) {
    for (int o = 0; o < outputs; ++o) {
      loss += static_cast<double>(
          static_cast<float>(o + 1) *
          out[s * static_cast<std::size_t>(network.output_stride()) + static_cast<std::size_t>(o)]);
    }
  }
  return loss;
}

TEST(Network, GradientsAgreeWithDifferences) {
  constexpr std::size_t kCount = 5;
  constexpr int kOutputs = 3;
  Network network({10, 20, 12, kOutputs}, 4);
  const auto stride = static_cast<std::size_t>(network.row_stride());
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<float> x(kCount * stride, 0.0F);
  for (std::size_t s = 0; s < kCount; ++s) {
    for (std::size_t i = 0; i < 10; ++i) {
      x[s * stride + i] = uniform(rng);
    }
  }
  Network::Activations activations;
  network.Forward(PortableKernels(), x.data(), kCount, &activations);
  const auto out_stride = static_cast<std::size_t>(network.output_stride());
  std::vector<float> d_out(kCount * out_stride, 0.0F);
  for (std::size_t s = 0; s < kCount; ++s) {
    for (std::size_t o = 0; o < kOutputs; ++o) {
      d_out[s * out_stride + o] = static_cast<float>(o + 1);
    }
  }
  std::vector<float> d_parameters(network.parameters().size(), 0.0F);
  std::vector<float> d_x(x.size(), NAN);
  network.Backward(PortableKernels(),
                   x.data(),
                   d_out.data(),
                   kCount,
                   &activations,
                   d_parameters.data(),
                   d_x.data());
  constexpr float kStep = 1e-3F;
  const auto difference = [&](float* value) {
    const float before = *value;
    *value = before + kStep;
    const double above = Loss(network, x, kCount, kOutputs);
    *value = before - kStep;
    const double below = Loss(network, x, kCount, kOutputs);
    *value = before;
    return (above - below) / (2 * static_cast<double>(kStep));
  };
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_NEAR(d_x[stride + i], difference(&x[stride + i]), 2e-2);
  }
  int nonzero = 0;
  for (std::size_t i = 0; i < d_parameters.size(); i += 7) {
    if (network.parameters()[i] != 0) {
      EXPECT_NEAR(d_parameters[i], difference(&network.parameters()[i]), 3e-2) << i;
      nonzero += d_parameters[i] != 0 ? 1 : 0;
    }
  }
  EXPECT_GT(nonzero, 20);
}

}  // namespace
}  // namespace deja_view::nerf
