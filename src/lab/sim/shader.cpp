#include "deja_view/lab/sim/shader.hpp"

#include "deja_view/lab/sim/light.hpp"

#include <algorithm>
#include <iterator>
#include <optional>

#include "shade_kernel.hpp"

namespace deja_view::sim {

Shader::Shader(const Scene& scene, float sample_angle)
    : scene_(scene), sample_angle_(sample_angle) {
  for (const Surface& surface : scene.surfaces) {
    const Texture& texture = scene.textures[static_cast<std::size_t>(surface.texture)];
    ShadedSurface& s = surfaces_.emplace_back();
    s.emission = surface.emission;
    s.periods_per_u = 1.0F / surface.period.x();
    s.periods_per_v = 1.0F / surface.period.y();
    s.origin_u = surface.texture_origin.x();
    s.origin_v = surface.texture_origin.y();
    s.texels_per_range = sample_angle * static_cast<float>(texture.size()) *
                         std::max(s.periods_per_u, s.periods_per_v);
    s.texture_size = texture.size();
    s.last_level = texture.levels() - 1;
    s.texels = texture.texels();
    s.level_offsets = texture.level_offsets();
    s.light_per_u = static_cast<float>(surface.light_u - 1) / surface.size_u;
    s.light_per_v = static_cast<float>(surface.light_v - 1) / surface.size_v;
    s.light_width = surface.light_u;
    s.light_height = surface.light_v;
    s.light = scene.light.data() + surface.light_offset;
  }
  const auto is_glossy = [](const Surface& surface) { return surface.gloss > 0; };
  if (std::any_of(scene.surfaces.begin(), scene.surfaces.end(), is_glossy)) {
    std::copy_if(scene.surfaces.begin(),
                 scene.surfaces.end(),
                 std::back_inserter(mirrored_lights_.surfaces),
                 [](const Surface& surface) { return surface.emission > 0; });
  }
}

Shader::Lanes Shader::Shade(const RayPacket& packet) const {
  Lanes radiance;
  ShadePacket(surfaces_.data(), packet, &radiance);
  if (!mirrored_lights_.surfaces.empty()) {
    for (int i = 0; i < RayPacket::kSize; ++i) {
      radiance[i] += Mirrored(packet, i);
    }
  }
  return radiance;
}

float Shader::Mirrored(const RayPacket& packet, int lane) const {
  if (packet.surface[lane] < 0) {
    return 0.0F;
  }
  const Surface& s = scene_.surfaces[static_cast<std::size_t>(packet.surface[lane])];
  if (!(s.gloss > 0)) {
    return 0.0F;
  }
  constexpr float kOffTheSurface_m = 1e-3F;
  const Eigen::Vector3f p = s.Point(packet.u[lane], packet.v[lane]);
  const Eigen::Vector3f normal = s.NormalAt(packet.u[lane]);
  const Eigen::Vector3f ray = (p - packet.origin).normalized();
  const Eigen::Vector3d from = (p + kOffTheSurface_m * normal).cast<double>();
  const Eigen::Vector3d to = (ray - 2 * ray.dot(normal) * normal).cast<double>();
  // Few rays meet a light, so that few are cast into the whole scene, for what stands before it.
  const auto hit = CastRay(mirrored_lights_, from, to) ? CastRay(scene_, from, to) : std::nullopt;
  if (!hit) {
    return 0.0F;
  }
  const float slant = 1.0F - std::clamp(packet.cosine[lane], 0.0F, 1.0F);
  const float slant_squared = slant * slant;
  const float share = s.gloss + (1.0F - s.gloss) * slant_squared * slant_squared * slant;
  return share * scene_.surfaces[static_cast<std::size_t>(hit->surface)].emission;
}

float Shader::ShadeOne(const RayPacket& packet, int lane) const {
  if (packet.surface[lane] < 0) {
    return 0.0F;
  }
  const Surface& s = scene_.surfaces[static_cast<std::size_t>(packet.surface[lane])];
  if (s.emission > 0) {
    return s.emission;
  }
  const float cosine = std::max(kLeastCosine, packet.cosine[lane]);
  const float footprint = packet.range[lane] * sample_angle_ / std::sqrt(cosine);
  const float u = packet.u[lane];
  const float v = packet.v[lane];
  const float reflectance = scene_.textures[static_cast<std::size_t>(s.texture)].Sample(
      s.texture_origin.x() + u / s.period.x(),
      s.texture_origin.y() + v / s.period.y(),
      footprint / std::min(s.period.x(), s.period.y()));
  const float mirrored = mirrored_lights_.surfaces.empty() ? 0.0F : Mirrored(packet, lane);
  return reflectance * SampleLight(scene_, s, u, v) + mirrored;
}

}  // namespace deja_view::sim
