// The kernels of the feature grid, for simd_kernels.cpp: included once per instruction set, hence
// Highway's toggle in place of an include guard.
#if defined(DEJA_VIEW_SIMD_GRID_KERNELS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef DEJA_VIEW_SIMD_GRID_KERNELS_INL
#undef DEJA_VIEW_SIMD_GRID_KERNELS_INL
#else
#define DEJA_VIEW_SIMD_GRID_KERNELS_INL
#endif

#include "deja_view/nerf/kernel_table.hpp"

#include <algorithm>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace deja_view::nerf {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kBlock = 64;

/// Offsets of values and weights of the eight corners of up to kBlock samples.
struct CornerBlock {
  alignas(64) std::uint32_t value[8][kBlock];
  alignas(64) float weight[8][kBlock];
};

// The caller's arrays may end after `left` values: hence the copy for a tail.
HWY_INLINE hn::Vec<hn::ScalableTag<float>> LoadLanes(const float* from, std::size_t left) {
  const hn::ScalableTag<float> df;
  if (left >= hn::Lanes(df)) {
    return hn::LoadU(df, from);
  }
  alignas(64) float tail[HWY_MAX_BYTES / sizeof(float)] = {};
  std::copy_n(from, left, tail);
  return hn::Load(df, tail);
}

template <bool kHashed>
void FindCorners(const GridLevel& level,
                 const Positions& p,
                 std::size_t begin,
                 std::size_t count,
                 CornerBlock* HWY_RESTRICT block) {
  const hn::ScalableTag<float> df;
  const hn::RebindToSigned<decltype(df)> di;
  const hn::RebindToUnsigned<decltype(df)> du;
  const std::size_t lanes = hn::Lanes(df);
  const auto scale = hn::Set(df, level.scale);
  const auto one_f = hn::Set(df, 1.0F);
  const auto one = hn::Set(du, 1U);
  const int shift = level.features == 4 ? 2 : 1;
  for (std::size_t s = 0; s < count; s += lanes) {
    const auto load = [&](const float* from)
                          HWY_ATTR { return LoadLanes(from + begin + s, count - s); };
    const auto px = hn::Mul(load(p.x), scale);
    const auto py = hn::Mul(load(p.y), scale);
    const auto pz = hn::Mul(load(p.z), scale);
    const auto ix = hn::ConvertTo(di, px);
    const auto iy = hn::ConvertTo(di, py);
    const auto iz = hn::ConvertTo(di, pz);
    const auto fx = hn::Sub(px, hn::ConvertTo(df, ix));
    const auto fy = hn::Sub(py, hn::ConvertTo(df, iy));
    const auto fz = hn::Sub(pz, hn::ConvertTo(df, iz));
    const auto ux = hn::BitCast(du, ix);
    const auto uy = hn::BitCast(du, iy);
    const auto uz = hn::BitCast(du, iz);
    const auto mul_y = hn::Set(du, kHashed ? 2654435761U : level.stride_y);
    const auto mul_z = hn::Set(du, kHashed ? 805459861U : level.stride_z);
    const auto mask = hn::Set(du, level.mask);
    const decltype(ux) brick_x[2] = {hn::ShiftRight<1>(ux), hn::ShiftRight<1>(hn::Add(ux, one))};
    const decltype(ux) brick_y[2] = {hn::Mul(hn::ShiftRight<1>(uy), mul_y),
                                     hn::Mul(hn::ShiftRight<1>(hn::Add(uy, one)), mul_y)};
    const decltype(ux) brick_z[2] = {hn::Mul(hn::ShiftRight<1>(uz), mul_z),
                                     hn::Mul(hn::ShiftRight<1>(hn::Add(uz, one)), mul_z)};
    const auto low_x = hn::And(ux, one);
    const auto low_y = hn::And(uy, one);
    const auto low_z = hn::And(uz, one);
    const decltype(ux) local_x[2] = {low_x, hn::Xor(low_x, one)};
    const decltype(ux) local_y[2] = {hn::ShiftLeft<1>(low_y),
                                     hn::ShiftLeft<1>(hn::Xor(low_y, one))};
    const decltype(ux) local_z[2] = {hn::ShiftLeft<2>(low_z),
                                     hn::ShiftLeft<2>(hn::Xor(low_z, one))};
    const decltype(fx) weight_x[2] = {hn::Sub(one_f, fx), fx};
    const decltype(fx) weight_y[2] = {hn::Sub(one_f, fy), fy};
    const decltype(fx) weight_z[2] = {hn::Sub(one_f, fz), fz};
    for (std::size_t c = 0; c < 8; ++c) {
      const std::size_t a = c & 1U, b = c >> 1U & 1U, d = c >> 2U;
      const auto brick = kHashed
                             ? hn::And(hn::Xor(hn::Xor(brick_x[a], brick_y[b]), brick_z[d]), mask)
                             : hn::Add(hn::Add(brick_x[a], brick_y[b]), brick_z[d]);
      const auto local = hn::Or(hn::Or(local_x[a], local_y[b]), local_z[d]);
      const auto entry = hn::Or(hn::ShiftLeft<3>(brick), local);
      hn::Store(hn::ShiftLeftSame(entry, shift), du, block->value[c] + s);
      hn::Store(hn::Mul(hn::Mul(weight_x[a], weight_y[b]), weight_z[d]), df, block->weight[c] + s);
    }
  }
}

void FindCorners(const GridLevel& level,
                 const Positions& p,
                 std::size_t begin,
                 std::size_t count,
                 CornerBlock* HWY_RESTRICT block) {
  if (level.hashed) {
    FindCorners<true>(level, p, begin, count, block);
  } else {
    FindCorners<false>(level, p, begin, count, block);
  }
}

template <int kFeatures>
void GridForwardOf(const GridLevel& level,
                   const float* HWY_RESTRICT table,
                   const Positions& p,
                   std::size_t count,
                   float* HWY_RESTRICT out,
                   std::size_t stride) {
  const hn::FixedTag<float, kFeatures> d;
  CornerBlock block;
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t size = std::min(kBlock, count - begin);
    FindCorners(level, p, begin, size, &block);
    for (std::size_t s = 0; s < size; ++s) {
      auto even = hn::Mul(hn::Set(d, block.weight[0][s]), hn::LoadU(d, table + block.value[0][s]));
      auto odd = hn::Mul(hn::Set(d, block.weight[1][s]), hn::LoadU(d, table + block.value[1][s]));
      for (std::size_t c = 2; c < 8; c += 2) {
        even = hn::MulAdd(
            hn::Set(d, block.weight[c][s]), hn::LoadU(d, table + block.value[c][s]), even);
        odd = hn::MulAdd(
            hn::Set(d, block.weight[c + 1][s]), hn::LoadU(d, table + block.value[c + 1][s]), odd);
      }
      hn::StoreU(hn::Add(even, odd), d, out + (begin + s) * stride);
    }
  }
}

void GridForward(const GridLevel& level,
                 const float* table,
                 const Positions& p,
                 std::size_t count,
                 float* out,
                 std::size_t stride) {
  if (level.features == 4) {
    GridForwardOf<4>(level, table, p, count, out, stride);
  } else {
    GridForwardOf<2>(level, table, p, count, out, stride);
  }
}

template <int kFeatures>
void GridBackwardOf(const GridLevel& level,
                    const Positions& p,
                    std::size_t count,
                    const float* HWY_RESTRICT d_out,
                    float* HWY_RESTRICT gradient,
                    std::uint8_t* HWY_RESTRICT touched) {
  const hn::FixedTag<float, kFeatures> d;
  CornerBlock block;
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t size = std::min(kBlock, count - begin);
    FindCorners(level, p, begin, size, &block);
    for (std::size_t s = 0; s < size; ++s) {
      const auto g = hn::LoadU(d, d_out + (begin + s) * kFeatures);
      for (std::size_t c = 0; c < 8; ++c) {
        const std::uint32_t value = block.value[c][s];
        touched[value / (8 * kFeatures)] = 1;
        float* to = gradient + value;
        hn::StoreU(hn::MulAdd(hn::Set(d, block.weight[c][s]), g, hn::LoadU(d, to)), d, to);
      }
    }
  }
}

void GridBackward(const GridLevel& level,
                  const Positions& p,
                  std::size_t count,
                  const float* d_out,
                  float* gradient,
                  std::uint8_t* touched) {
  if (level.features == 4) {
    GridBackwardOf<4>(level, p, count, d_out, gradient, touched);
  } else {
    GridBackwardOf<2>(level, p, count, d_out, gradient, touched);
  }
}

#endif  // HWY_TARGET != HWY_SCALAR

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace deja_view::nerf
HWY_AFTER_NAMESPACE();

#endif  // the toggle
