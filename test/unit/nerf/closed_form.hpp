#pragma once

#include "deja_view/nerf/radiance_field.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view::nerf {

inline FieldOptions SmallFieldOptions() {
  FieldOptions options;
  options.geometry = {3, 2, 12, 4, 16};
  options.appearance = {2, 4, 10, 8, 32};
  options.color_hidden = 16;
  options.occupancy_resolution = 32;
  return options;
}

/// A field in a box of 4 x 3 x 2 m with the density `sigma` per metre and one radiance everywhere.
inline RadianceField ConstantField(double sigma, float radiance, int channels = 1) {
  SceneBox box;
  box.min = {-1, -1, -1};
  box.max = {3, 2, 1};
  MarchOptions march;
  march.min_weight = 0;
  march.min_transmittance = 0;
  march.max_samples = 65536;
  RadianceField field(SmallFieldOptions(), march, box, channels, 1);
  std::fill(field.density.parameters().begin(), field.density.parameters().end(), 0.0F);
  std::fill(field.color.parameters().begin(), field.color.parameters().end(), 0.0F);
  field.density.OutputBias(0) = static_cast<float>(std::log(sigma * box.Size()));
  for (int c = 0; c < channels; ++c) {
    field.color.OutputBias(c) = std::log(radiance / (1 - radiance));
  }
  field.density.UpdateTranspose();
  field.color.UpdateTranspose();
  return field;
}

}  // namespace deja_view::nerf
