#include "deja_view/lab/sim/light.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"
#include "deja_view/lab/sim/beam_caster.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace deja_view::sim {
namespace {

constexpr float kAmbient = 0.34F;
constexpr float kAmbientReach = 1.5F;  // [m]
constexpr float kLift = 0.01F;         // [m] above the surface, so that it does not shade itself

/// One point of a lamp with its caster.
struct PointLight {
  Eigen::Vector3f p_W;
  Eigen::Vector3f normal;
  float intensity;
  BeamCaster caster;
};

/// A texel of a light map.
struct Texel {
  Eigen::Vector3f p_W, normal;
  float* light;
};

std::vector<PointLight> MakePointLights(const Scene& scene, const std::vector<LightSource>& lamps) {
  std::vector<PointLight> points;
  for (const LightSource& lamp : lamps) {
    for (const Eigen::Vector3f& p : lamp.points) {
      const Rigid3 T_W_A{Eigen::Quaterniond::Identity(), p.cast<double>()};
      const float share = lamp.intensity / static_cast<float>(lamp.points.size());
      points.push_back({p, lamp.normal, share, BeamCaster(scene, T_W_A)});
    }
  }
  return points;
}

/// Adds what one point light gives to up to RayPacket::kSize texels.
void AddPointLight(const PointLight& light,
                   const std::vector<std::int32_t>& candidates,
                   const Texel* texels,
                   int count) {
  RayPacket packet;
  std::array<float, RayPacket::kSize> distance{};
  for (int i = 0; i < RayPacket::kSize; ++i) {
    const Texel& texel = texels[std::min(i, count - 1)];
    const Eigen::Vector3f ray = texel.p_W - light.p_W;
    distance[i] = ray.norm();
    packet.x[i] = ray.x() / distance[i];
    packet.y[i] = ray.y() / distance[i];
    packet.z[i] = ray.z() / distance[i];
  }
  light.caster.Trace(candidates, &packet);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f direction(packet.x[i], packet.y[i], packet.z[i]);
    const float received = -direction.dot(texels[i].normal);
    const float sent = direction.dot(light.normal);
    if (received > 0 && sent > 0 && packet.range[i] > distance[i] - 2 * kLift) {
      const float spread = distance[i] * distance[i] + 0.5F;
      *texels[i].light += light.intensity * received * std::sqrt(sent) / spread;
    }
  }
}

/// Directions spread evenly, cosine weighted, over the hemisphere about `normal`.
void FillHemisphere(const Eigen::Vector3f& normal, RayPacket* packet) {
  const Eigen::Vector3f a = normal.unitOrthogonal();
  const Eigen::Vector3f b = normal.cross(a);
  for (int i = 0; i < RayPacket::kSize; ++i) {
    const float radius = std::sqrt((static_cast<float>(i) + 0.5F) / RayPacket::kSize);
    const float angle = 2.3999632F * static_cast<float>(i);  // golden angle
    const float up = std::sqrt(1.0F - radius * radius);
    const Eigen::Vector3f d =
        radius * std::cos(angle) * a + radius * std::sin(angle) * b + up * normal;
    packet->x[i] = d.x();
    packet->y[i] = d.y();
    packet->z[i] = d.z();
  }
}

float AmbientLight(const Scene& nearby, const Texel& texel) {
  const BeamCaster caster(nearby, {Eigen::Quaterniond::Identity(), texel.p_W.cast<double>()});
  RayPacket packet;
  FillHemisphere(texel.normal, &packet);
  caster.Trace(caster.visible(), &packet);
  float closed = 0;
  for (const float range : packet.range) {
    closed += range < kAmbientReach ? 1.0F - range / kAmbientReach : 0.0F;
  }
  return kAmbient * (1.0F - 0.9F * closed / RayPacket::kSize);
}

/// Bounding sphere of a surface: centre and radius.
std::pair<Eigen::Vector3f, float> Bounds(const Surface& s) {
  if (s.shape == Shape::kCylinder) {
    const Eigen::Vector3f centre = s.origin + 0.5F * s.size_v * s.axis_v;
    return {centre, std::hypot(s.Radius(), 0.5F * s.size_v)};
  }
  return {s.Point(0.5F * s.size_u, 0.5F * s.size_v), 0.5F * std::hypot(s.size_u, s.size_v)};
}

/// The surfaces that come within reach of a texel, without their textures.
Scene Nearby(const Scene& scene, const std::vector<Texel>& texels) {
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  for (const Texel& texel : texels) {
    middle += texel.p_W / static_cast<float>(texels.size());
  }
  float reach = 0;
  for (const Texel& texel : texels) {
    reach = std::max(reach, (texel.p_W - middle).norm());
  }
  Scene nearby;
  for (const Surface& surface : scene.surfaces) {
    const auto [centre, radius] = Bounds(surface);
    if ((centre - middle).norm() < radius + reach + kAmbientReach) {
      nearby.surfaces.push_back(surface);
    }
  }
  return nearby;
}

void LightBlock(const Scene& scene,
                const std::vector<PointLight>& lights,
                std::vector<Texel>* block) {
  const Scene nearby = Nearby(scene, *block);
  for (const Texel& texel : *block) {
    *texel.light = AmbientLight(nearby, texel);
  }
  std::vector<std::int32_t> candidates;
  std::vector<Eigen::Vector3f> directions;
  for (const PointLight& light : lights) {
    directions.clear();
    bool faces = false;
    for (const Texel& texel : *block) {
      const Eigen::Vector3f ray = texel.p_W - light.p_W;
      faces |= ray.dot(texel.normal) < 0 && ray.dot(light.normal) > 0;
      directions.push_back(ray.normalized());
    }
    if (!faces) {
      continue;
    }
    light.caster.Cull(BoundingCone(directions, 1e-3F), light.caster.visible(), &candidates);
    const int count = static_cast<int>(block->size());
    for (int i = 0; i < count; i += RayPacket::kSize) {
      AddPointLight(light, candidates, block->data() + i, std::min(RayPacket::kSize, count - i));
    }
  }
}

/// Lays out the light maps; returns the blocks of texels, each a compact patch of one surface.
std::vector<std::vector<Texel>> LayOutLightMaps(double spacing, Scene* scene) {
  std::size_t total = 0;
  const auto grid = [&](float size) {
    return std::max(2, static_cast<int>(std::lround(size / spacing)) + 1);
  };
  for (Surface& s : scene->surfaces) {
    const bool dark = s.emission > 0;
    s.light_u = dark ? 2 : grid(s.size_u);
    s.light_v = dark ? 2 : grid(s.size_v);
    s.light_offset = total;
    total += static_cast<std::size_t>(s.light_u) * static_cast<std::size_t>(s.light_v);
  }
  scene->light.assign(total, 0.0F);
  constexpr int kBlock = 8;
  std::vector<std::vector<Texel>> blocks;
  for (const Surface& s : scene->surfaces) {
    for (int v0 = 0; s.emission <= 0 && v0 < s.light_v; v0 += kBlock) {
      for (int u0 = 0; u0 < s.light_u; u0 += kBlock) {
        std::vector<Texel>& block = blocks.emplace_back();
        for (int v = v0; v < std::min(v0 + kBlock, s.light_v); ++v) {
          for (int u = u0; u < std::min(u0 + kBlock, s.light_u); ++u) {
            // A little inside, so that a texel on an edge is not within the neighbouring surface.
            const auto at = [](int i, int n, float size) {
              return std::clamp(size * static_cast<float>(i) / static_cast<float>(n - 1),
                                0.04F * size,
                                0.96F * size);
            };
            const float pu = s.shape == Shape::kCylinder ? s.size_u * static_cast<float>(u) /
                                                               static_cast<float>(s.light_u - 1)
                                                         : at(u, s.light_u, s.size_u);
            const Eigen::Vector3f normal = s.NormalAt(pu);
            float* light =
                &scene->light[s.light_offset + static_cast<std::size_t>(v * s.light_u + u)];
            block.push_back(
                {s.Point(pu, at(v, s.light_v, s.size_v)) + kLift * normal, normal, light});
          }
        }
      }
    }
  }
  return blocks;
}

}  // namespace

void BakeLight(const std::vector<LightSource>& lamps, double spacing, int threads, Scene* scene) {
  DEJA_VIEW_CHECK_OP(spacing, >, 0.0);
  auto blocks = LayOutLightMaps(spacing, scene);
  const std::vector<PointLight> lights = MakePointLights(*scene, lamps);
  ParallelFor(
      threads,
      blocks.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          LightBlock(*scene, lights, &blocks[i]);
        }
      },
      4);
}

float SampleLight(const Scene& scene, const Surface& surface, float u, float v) {
  const float x =
      std::clamp(u / surface.size_u, 0.0F, 1.0F) * static_cast<float>(surface.light_u - 1);
  const float y =
      std::clamp(v / surface.size_v, 0.0F, 1.0F) * static_cast<float>(surface.light_v - 1);
  const int x0 = std::min(static_cast<int>(x), surface.light_u - 2);
  const int y0 = std::min(static_cast<int>(y), surface.light_v - 2);
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const float* row = scene.light.data() + surface.light_offset + y0 * surface.light_u + x0;
  const float low = row[0] + (row[1] - row[0]) * fx;
  const float* next = row + surface.light_u;
  const float high = next[0] + (next[1] - next[0]) * fx;
  return low + (high - low) * fy;
}

}  // namespace deja_view::sim
