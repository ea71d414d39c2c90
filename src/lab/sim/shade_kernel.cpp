// As packet_kernel.cpp: plain loops over lanes, compiled once per instruction set.
#include "shade_kernel.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shade_kernel.cpp"
#include "deja_view/base/instruction_sets-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace deja_view::sim::HWY_NAMESPACE {
namespace {

constexpr int kSize = RayPacket::kSize;
/// As std::floor for values that fit an int, in two vector instructions.
inline std::int32_t Floor(float x) {
  const auto truncated = static_cast<std::int32_t>(x);
  return truncated - (static_cast<float>(truncated) > x ? 1 : 0);
}

/// As in Texture::Sample, from the bits of x >= 1.
inline float FastLog2(float x) {
  std::int32_t bits = 0;
  std::memcpy(&bits, &x, sizeof(bits));
  const std::int32_t exponent = (bits >> 23) - 127;
  return static_cast<float>(exponent) + static_cast<float>(bits & 0x7fffff) * 0x1.0p-23F;
}

inline float Decode(std::uint32_t quad, unsigned shift) {
  const float root =
      static_cast<float>(static_cast<std::int32_t>((quad >> shift) & 255U)) * (1.0F / 255.0F);
  return root * root;
}

inline float Mix(float a, float b, float weight) {
  return a + (b - a) * weight;
}

/// Texture::SampleLevel for all lanes, each at its own level.
inline void SampleLevels(const ShadedSurface& s,
                         const Lanes& u,
                         const Lanes& v,
                         const std::int32_t* level,
                         Lanes* value) {
  const std::uint32_t* const texels = s.texels;
  const std::int32_t* const offsets = s.level_offsets;
  const std::int32_t texture_size = s.texture_size;
  for (int i = 0; i < kSize; ++i) {
    const std::int32_t size = texture_size >> level[i];
    const float x = u[i] * static_cast<float>(size) - 0.5F;
    const float y = v[i] * static_cast<float>(size) - 0.5F;
    const std::int32_t column = Floor(x);
    const std::int32_t row = Floor(y);
    const float fx = x - static_cast<float>(column);
    const float fy = y - static_cast<float>(row);
    const std::int32_t index =
        offsets[level[i]] + (row & (size - 1)) * size + (column & (size - 1));
    const std::uint32_t quad = texels[index];
    const float top = Mix(Decode(quad, 0), Decode(quad, 8), fx);
    const float bottom = Mix(Decode(quad, 16), Decode(quad, 24), fx);
    (*value)[i] = Mix(top, bottom, fy);
  }
}

/// Texture::Sample for all lanes.
inline void SampleTexture(
    const ShadedSurface& s, const Lanes& u, const Lanes& v, const Lanes& texels, Lanes* value) {
  std::array<std::int32_t, kSize> fine{};
  std::array<std::int32_t, kSize> coarse{};
  Lanes weight;
  const std::int32_t last = s.last_level;
  for (int i = 0; i < kSize; ++i) {
    const float width = texels[i] > 1.0F ? texels[i] : 1.0F;
    const float log = FastLog2(width);
    const float level = log < static_cast<float>(last) ? log : static_cast<float>(last);
    fine[i] = static_cast<std::int32_t>(level);
    coarse[i] = fine[i] + 1 < last ? fine[i] + 1 : last;
    weight[i] = level - static_cast<float>(fine[i]);
  }
  Lanes coarse_value;
  SampleLevels(s, u, v, fine.data(), value);
  SampleLevels(s, u, v, coarse.data(), &coarse_value);
  for (int i = 0; i < kSize; ++i) {
    (*value)[i] = Mix((*value)[i], coarse_value[i], weight[i]);
  }
}

/// SampleLight for all lanes.
inline void SampleLightMap(const ShadedSurface& s, const Lanes& u, const Lanes& v, Lanes* value) {
  const auto last_x = static_cast<float>(s.light_width - 1);
  const auto last_y = static_cast<float>(s.light_height - 1);
  const float* const light = s.light;
  const std::int32_t width = s.light_width;
  const std::int32_t height = s.light_height;
  for (int i = 0; i < kSize; ++i) {
    float x = u[i] * s.light_per_u;
    float y = v[i] * s.light_per_v;
    x = x > 0.0F ? x : 0.0F;
    y = y > 0.0F ? y : 0.0F;
    x = x < last_x ? x : last_x;
    y = y < last_y ? y : last_y;
    auto column = static_cast<std::int32_t>(x);
    auto row = static_cast<std::int32_t>(y);
    column = column < width - 2 ? column : width - 2;
    row = row < height - 2 ? row : height - 2;
    const float fx = x - static_cast<float>(column);
    const float fy = y - static_cast<float>(row);
    const std::int32_t index = row * width + column;
    const float low = Mix(light[index], light[index + 1], fx);
    const float high = Mix(light[index + width], light[index + width + 1], fx);
    (*value)[i] = Mix(low, high, fy);
  }
}

/// Shades the lanes that hit surface `index`; the others go through the motions at u = v = 0.
inline void ShadeSurface(const ShadedSurface& s,
                         const RayPacket& p,
                         std::int32_t index,
                         Lanes* radiance) {
  if (s.emission > 0) {
    for (int i = 0; i < kSize; ++i) {
      (*radiance)[i] = p.surface[i] == index ? s.emission : (*radiance)[i];
    }
    return;
  }
  Lanes u;
  Lanes v;
  Lanes texture_u;
  Lanes texture_v;
  Lanes texels;
  Lanes reflectance;
  Lanes light;
  for (int i = 0; i < kSize; ++i) {
    const bool is_hit = p.surface[i] == index;
    u[i] = is_hit ? p.u[i] : 0.0F;
    v[i] = is_hit ? p.v[i] : 0.0F;
    texture_u[i] = s.origin_u + u[i] * s.periods_per_u;
    texture_v[i] = s.origin_v + v[i] * s.periods_per_v;
    // A ray's cone covers an ellipse that slant lengthens; the geometric mean of its axes neither
    // flickers nor blurs.
    const float range = is_hit ? p.range[i] : 0.0F;
    const float cosine = p.cosine[i] > kLeastCosine ? p.cosine[i] : kLeastCosine;
    texels[i] = range * s.texels_per_range / std::sqrt(cosine);
  }
  SampleTexture(s, texture_u, texture_v, texels, &reflectance);
  SampleLightMap(s, u, v, &light);
  for (int i = 0; i < kSize; ++i) {
    (*radiance)[i] = p.surface[i] == index ? reflectance[i] * light[i] : (*radiance)[i];
  }
}

inline void ShadeAll(const ShadedSurface* surfaces, const RayPacket& p, Lanes* radiance) {
  radiance->fill(0.0F);
  std::uint32_t open = 0;
  for (int i = 0; i < kSize; ++i) {
    open |= p.surface[i] >= 0 ? 1U << static_cast<unsigned>(i) : 0U;
  }
  while (open != 0) {
    const std::int32_t index = p.surface[__builtin_ctz(open)];
    ShadeSurface(surfaces[index], p, index, radiance);
    for (int i = 0; i < kSize; ++i) {
      open &= ~(p.surface[i] == index ? 1U << static_cast<unsigned>(i) : 0U);
    }
  }
}

}  // namespace
}  // namespace deja_view::sim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace deja_view::sim {

HWY_EXPORT(ShadeAll);

void ShadePacket(const ShadedSurface* surfaces, const RayPacket& packet, Lanes* radiance) {
  HWY_DYNAMIC_DISPATCH(ShadeAll)(surfaces, packet, radiance);
}

}  // namespace deja_view::sim
#endif
