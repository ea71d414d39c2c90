#include "backward.hpp"

#include <algorithm>

namespace deja_view::nerf::internal {
namespace {

// Rows of features to one array per level, which is read in one go later.
void SplitLevels(const FeatureGrid& grid,
                 const std::vector<float>& rows,
                 std::size_t stride,
                 std::size_t count,
                 std::vector<std::vector<float>>* levels) {
  levels->resize(grid.levels().size());
  std::size_t column = 0;
  for (std::size_t l = 0; l < grid.levels().size(); ++l) {
    const auto features = static_cast<std::size_t>(grid.levels()[l].features);
    std::vector<float>& out = (*levels)[l];
    out.resize(count * features);
    for (std::size_t s = 0; s < count; ++s) {
      for (std::size_t f = 0; f < features; ++f) {
        out[s * features + f] = rows[s * stride + column + f];
      }
    }
    column += features;
  }
}

void BackpropagateBackground(const RadianceField& field,
                             const Kernels& kernels,
                             const LossGradient& loss,
                             Trace* trace,
                             BackwardScratch* scratch,
                             ChunkGradient* gradient) {
  const std::size_t rays = trace->background_x.size();
  const auto stride = static_cast<std::size_t>(field.background_color.row_stride());
  gradient->background.x = trace->background_x;
  gradient->background.y = trace->background_y;
  gradient->background.z = trace->background_z;
  gradient->background_network.assign(field.background_color.parameters().size(), 0.0F);
  scratch->d_rows.resize(rays * stride);
  field.background_color.Backward(kernels,
                                  trace->background_rows.data(),
                                  loss.d_background_rows.data(),
                                  rays,
                                  &trace->background_activations,
                                  gradient->background_network.data(),
                                  scratch->d_rows.data());
  SplitLevels(field.background, scratch->d_rows, stride, rays, &gradient->background.levels);
}

}  // namespace

void Backpropagate(const RadianceField& field,
                   const Kernels& kernels,
                   const LossGradient& loss,
                   Trace* trace,
                   BackwardScratch* scratch,
                   ChunkGradient* gradient) {
  const std::size_t count = trace->size();
  for (GridGradient* grid : {&gradient->geometry, &gradient->appearance}) {
    grid->x = trace->x;
    grid->y = trace->y;
    grid->z = trace->z;
  }

  const auto color_stride = static_cast<std::size_t>(field.color.row_stride());
  gradient->color_network.assign(field.color.parameters().size(), 0.0F);
  scratch->d_rows.resize(count * color_stride);
  field.color.Backward(kernels,
                       trace->appearance_rows.data(),
                       loss.d_color_rows.data(),
                       count,
                       &trace->color_activations,
                       gradient->color_network.data(),
                       scratch->d_rows.data());
  SplitLevels(field.appearance, scratch->d_rows, color_stride, count, &gradient->appearance.levels);
  const auto latent_size = static_cast<std::size_t>(field.options.latent_size);
  gradient->latent.assign((trace->ray_begin.size() - 1) * latent_size, 0.0F);
  for (std::size_t s = 0; s < count && latent_size > 0; ++s) {
    const float* from = scratch->d_rows.data() + s * color_stride + LatentColumn(field);
    float* to = gradient->latent.data() + trace->ray[s] * latent_size;
    for (std::size_t i = 0; i < latent_size; ++i) {
      to[i] += from[i];
    }
  }

  if (field.options.far_background) {
    BackpropagateBackground(field, kernels, loss, trace, scratch, gradient);
  }

  const auto density_stride = static_cast<std::size_t>(field.density.row_stride());
  const auto out_stride = static_cast<std::size_t>(field.density.output_stride());
  field.density.Forward(kernels, trace->geometry_rows.data(), count, &scratch->density_activations);
  scratch->d_out.assign(count * out_stride, 0.0F);
  for (std::size_t s = 0; s < count; ++s) {
    scratch->d_out[s * out_stride] = loss.d_raw[s];
  }
  gradient->density_network.assign(field.density.parameters().size(), 0.0F);
  scratch->d_rows.resize(count * density_stride);
  field.density.Backward(kernels,
                         trace->geometry_rows.data(),
                         scratch->d_out.data(),
                         count,
                         &scratch->density_activations,
                         gradient->density_network.data(),
                         scratch->d_rows.data());
  SplitLevels(field.geometry, scratch->d_rows, density_stride, count, &gradient->geometry.levels);
}

}  // namespace deja_view::nerf::internal
