#include "deja_view/nerf/radiance_field.hpp"

#include "deja_view/base/check.hpp"

#include "spherical_harmonics.hpp"

namespace deja_view::nerf {
namespace {

// exp of it is the untrained density: about one half of the light passes the whole box.
constexpr float kInitialLogDensity = -0.5F;
constexpr int kBackgroundHidden = 16;

}  // namespace

RadianceField::RadianceField(const FieldOptions& field_options,
                             const MarchOptions& march_options,
                             const SceneBox& scene_box,
                             int channel_count,
                             std::uint64_t seed)
    : options(field_options), march(march_options), box(scene_box), channels(channel_count) {
  DEJA_VIEW_CHECK(options.Validate().empty());
  DEJA_VIEW_CHECK(channels == 1 || channels == 3);
  DEJA_VIEW_CHECK(box.min.allFinite() && box.max.allFinite());
  DEJA_VIEW_CHECK((box.max.array() > box.min.array()).all());
  geometry = FeatureGrid(options.geometry, Extent(), seed);
  appearance = FeatureGrid(options.appearance, Extent(), seed + 1);
  density = Network({geometry.outputs(), options.density_hidden, 1}, seed + 2);
  density.OutputBias(0) = kInitialLogDensity;
  const int degree = options.direction_degree;
  std::vector<int> sizes = {appearance.outputs() + (degree + 1) * (degree + 1) - 1 +
                            options.latent_size};
  sizes.insert(
      sizes.end(), static_cast<std::size_t>(options.color_hidden_layers), options.color_hidden);
  sizes.push_back(channels);
  color = Network(sizes, seed + 3);
  if (options.far_background) {
    background = FeatureGrid(options.background, Eigen::Vector3f::Ones(), seed + 4);
    background_color = Network({background.outputs(), kBackgroundHidden, channels}, seed + 5);
  }
  occupancy = OccupancyGrid(options.occupancy_resolution, Extent());
}

void EncodeDirection(int degree, const float* direction, float* out) {
  internal::WriteHarmonics(degree, direction, out);
}

}  // namespace deja_view::nerf
