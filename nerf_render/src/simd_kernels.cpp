// The kernels through Highway, compiled once per instruction set.
#include "simd_kernels.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd_kernels.cpp"
#include <algorithm>

// foreach_target comes first, the -inl file last.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
#include "simd_grid_kernels-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace deja_view::nerf {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR

// One lane at a time is what PortableKernels() does.
const Kernels* TargetKernels() {
  return nullptr;
}

#else

namespace hn = hwy::HWY_NAMESPACE;

// kRows rows by kVectors vectors of outputs stay in registers over all inputs.
template <std::size_t kRows, std::size_t kVectors>
void LayerTile(std::size_t inputs,
               std::size_t outputs,
               const float* HWY_RESTRICT weights,
               const float* HWY_RESTRICT bias,
               const float* HWY_RESTRICT x,
               bool relu,
               float* HWY_RESTRICT y) {
  const hn::ScalableTag<float> d;
  using V = decltype(hn::Zero(d));
  const std::size_t lanes = hn::Lanes(d);
  V sum[kRows][kVectors];
  for (std::size_t v = 0; v < kVectors; ++v) {
    const V start = bias != nullptr ? hn::LoadU(d, bias + v * lanes) : hn::Zero(d);
    for (std::size_t r = 0; r < kRows; ++r) {
      sum[r][v] = start;
    }
  }
  for (std::size_t i = 0; i < inputs; ++i) {
    V w[kVectors];
    for (std::size_t v = 0; v < kVectors; ++v) {
      w[v] = hn::LoadU(d, weights + i * outputs + v * lanes);
    }
    for (std::size_t r = 0; r < kRows; ++r) {
      const V in = hn::Set(d, x[r * inputs + i]);
      for (std::size_t v = 0; v < kVectors; ++v) {
        sum[r][v] = hn::MulAdd(in, w[v], sum[r][v]);
      }
    }
  }
  for (std::size_t r = 0; r < kRows; ++r) {
    for (std::size_t v = 0; v < kVectors; ++v) {
      const V value = relu ? hn::Max(sum[r][v], hn::Zero(d)) : sum[r][v];
      hn::StoreU(value, d, y + r * outputs + v * lanes);
    }
  }
}

template <std::size_t kRows, std::size_t kVectors>
void LayerColumns(std::size_t inputs,
                  std::size_t outputs,
                  const float* weights,
                  const float* bias,
                  const float* x,
                  std::size_t count,
                  bool relu,
                  float* y) {
  std::size_t s = 0;
  for (; s + kRows <= count; s += kRows) {
    LayerTile<kRows, kVectors>(
        inputs, outputs, weights, bias, x + s * inputs, relu, y + s * outputs);
  }
  for (; s < count; ++s) {
    LayerTile<1, kVectors>(inputs, outputs, weights, bias, x + s * inputs, relu, y + s * outputs);
  }
}

void LayerForward(const LayerShape& shape,
                  const float* weights,
                  const float* bias,
                  const float* x,
                  std::size_t count,
                  bool relu,
                  float* y) {
  const std::size_t lanes = hn::Lanes(hn::ScalableTag<float>());
  const auto inputs = static_cast<std::size_t>(shape.inputs);
  const auto outputs = static_cast<std::size_t>(shape.outputs);
  std::size_t o = 0;
  for (; o + 2 * lanes <= outputs; o += 2 * lanes) {
    const float* b = bias != nullptr ? bias + o : nullptr;
    LayerColumns<6, 2>(inputs, outputs, weights + o, b, x, count, relu, y + o);
  }
  for (; o < outputs; o += lanes) {
    const float* b = bias != nullptr ? bias + o : nullptr;
    LayerColumns<8, 1>(inputs, outputs, weights + o, b, x, count, relu, y + o);
  }
}

// d_weights of 4 inputs by one vector of outputs stay in registers over all samples.
void LayerGradient(const LayerShape& shape,
                   const float* HWY_RESTRICT x,
                   const float* HWY_RESTRICT d_y,
                   std::size_t count,
                   float* HWY_RESTRICT d_weights,
                   float* HWY_RESTRICT d_bias) {
  const hn::ScalableTag<float> d;
  using V = decltype(hn::Zero(d));
  const std::size_t lanes = hn::Lanes(d);
  const auto inputs = static_cast<std::size_t>(shape.inputs);
  const auto outputs = static_cast<std::size_t>(shape.outputs);
  constexpr std::size_t kRows = 8;
  for (std::size_t o = 0; o < outputs; o += lanes) {
    V bias = hn::LoadU(d, d_bias + o);
    for (std::size_t s = 0; s < count; ++s) {
      bias = hn::Add(bias, hn::LoadU(d, d_y + s * outputs + o));
    }
    hn::StoreU(bias, d, d_bias + o);
    for (std::size_t i = 0; i < inputs; i += kRows) {
      V sum[kRows];
      for (std::size_t r = 0; r < kRows; ++r) {
        sum[r] = hn::LoadU(d, d_weights + (i + r) * outputs + o);
      }
      for (std::size_t s = 0; s < count; ++s) {
        const V g = hn::LoadU(d, d_y + s * outputs + o);
        const float* row = x + s * inputs + i;
        for (std::size_t r = 0; r < kRows; ++r) {
          sum[r] = hn::MulAdd(hn::Set(d, row[r]), g, sum[r]);
        }
      }
      for (std::size_t r = 0; r < kRows; ++r) {
        hn::StoreU(sum[r], d, d_weights + (i + r) * outputs + o);
      }
    }
  }
}

void Adam(const AdamStep& step,
          std::size_t count,
          float* HWY_RESTRICT parameters,
          float* HWY_RESTRICT gradient,
          float* HWY_RESTRICT first,
          float* HWY_RESTRICT second) {
  const hn::ScalableTag<float> d;
  const std::size_t lanes = hn::Lanes(d);
  const auto rate1 = hn::Set(d, 1 - step.beta1);
  const auto rate2 = hn::Set(d, 1 - step.beta2);
  const auto learning_rate = hn::Set(d, step.learning_rate);
  const auto epsilon = hn::Set(d, step.epsilon);
  const auto decay = hn::Set(d, step.decay);
  for (std::size_t i = 0; i < count; i += lanes) {
    const auto g = hn::LoadU(d, gradient + i);
    const auto m0 = hn::LoadU(d, first + i);
    const auto v0 = hn::LoadU(d, second + i);
    const auto m = hn::MulAdd(rate1, hn::Sub(g, m0), m0);
    const auto v = hn::MulAdd(rate2, hn::Sub(hn::Mul(g, g), v0), v0);
    const auto p = hn::LoadU(d, parameters + i);
    const auto delta = hn::MulAdd(decay, p, hn::Div(m, hn::Add(hn::Sqrt(v), epsilon)));
    hn::StoreU(m, d, first + i);
    hn::StoreU(v, d, second + i);
    hn::StoreU(hn::NegMulAdd(learning_rate, delta, p), d, parameters + i);
    hn::StoreU(hn::Zero(d), d, gradient + i);
  }
}

template <typename Body>
HWY_INLINE void ForTail(std::size_t count, const Body& body) {
  const std::size_t lanes = hn::Lanes(hn::ScalableTag<float>());
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    body(i, lanes);
  }
  if (i < count) {
    body(i, count - i);
  }
}

HWY_INLINE hn::Vec<hn::ScalableTag<float>> LoadUpTo(const float* from, std::size_t count) {
  const hn::ScalableTag<float> d;
  if (count == hn::Lanes(d)) {
    return hn::LoadU(d, from);
  }
  alignas(64) float tail[HWY_MAX_BYTES / sizeof(float)] = {};
  std::copy_n(from, count, tail);
  return hn::Load(d, tail);
}

HWY_INLINE void StoreUpTo(hn::Vec<hn::ScalableTag<float>> value, float* to, std::size_t count) {
  const hn::ScalableTag<float> d;
  if (count == hn::Lanes(d)) {
    hn::StoreU(value, d, to);
    return;
  }
  alignas(64) float tail[HWY_MAX_BYTES / sizeof(float)];
  hn::Store(value, d, tail);
  std::copy_n(tail, count, to);
}

void Density(
    const float* raw, const float* dt, std::size_t count, float* sigma, float* transparency) {
  const hn::ScalableTag<float> d;
  ForTail(count, [&](std::size_t i, std::size_t size) HWY_ATTR {
    const auto cut = hn::Clamp(LoadUpTo(raw + i, size), hn::Set(d, -15.0F), hn::Set(d, 15.0F));
    const auto density = hn::Exp(d, cut);
    const auto depth = hn::Min(hn::Mul(density, LoadUpTo(dt + i, size)), hn::Set(d, 80.0F));
    StoreUpTo(density, sigma + i, size);
    StoreUpTo(hn::Exp(d, hn::Neg(depth)), transparency + i, size);
  });
}

void Sigmoid(const float* x, std::size_t count, float* y) {
  const hn::ScalableTag<float> d;
  ForTail(count, [&](std::size_t i, std::size_t size) HWY_ATTR {
    const auto cut = hn::Clamp(LoadUpTo(x + i, size), hn::Set(d, -30.0F), hn::Set(d, 30.0F));
    const auto one = hn::Set(d, 1.0F);
    StoreUpTo(hn::Div(one, hn::Add(one, hn::Exp(d, hn::Neg(cut)))), y + i, size);
  });
}

const Kernels* TargetKernels() {
  static constexpr Kernels kKernels = {HWY_TARGET == HWY_AVX3   ? "avx512"
                                       : HWY_TARGET == HWY_AVX2 ? "avx2"
                                       : HWY_TARGET == HWY_SSE4 ? "sse4"
                                                                : HWY_STR(HWY_NAMESPACE),
                                       GridForward,
                                       GridBackward,
                                       LayerForward,
                                       LayerGradient,
                                       Adam,
                                       Density,
                                       Sigmoid};
  return &kKernels;
}

#endif  // HWY_TARGET == HWY_SCALAR

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace deja_view::nerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace deja_view::nerf {

HWY_EXPORT(TargetKernels);

namespace internal {

std::vector<const Kernels*> SimdKernels() {
  std::vector<const Kernels*> kernels;
  // Lower bits are better targets; each is asked for on its own, without touching Highway's choice.
  for (std::int64_t targets = hwy::SupportedTargets() & HWY_TARGETS; targets != 0;
       targets &= targets - 1) {
    hwy::ChosenTarget chosen;
    chosen.Update(targets & -targets);
    const Kernels* found = HWY_DISPATCH_TABLE(TargetKernels)[chosen.GetIndex()]();
    if (found != nullptr && (kernels.empty() || kernels.back() != found)) {
      kernels.push_back(found);
    }
  }
  return kernels;
}

}  // namespace internal
}  // namespace deja_view::nerf
#endif  // HWY_ONCE
