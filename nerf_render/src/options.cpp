#include "deja_view/nerf/options.hpp"

#include "deja_view/base/requirements.hpp"

namespace deja_view::nerf {
namespace {

std::vector<std::string> Violations(const GridOptions& grid) {
  Requirements r;
  r.Range("levels", grid.levels, 1, 24);
  r.That(grid.features == 2 || grid.features == 4, "features", grid.features, "2 or 4");
  r.Range("log2_table_size", grid.log2_table_size, 9, 24);
  r.Range("base_resolution", grid.base_resolution, 2, 16384);
  r.Range("finest_resolution", grid.finest_resolution, grid.base_resolution, 65536);
  return r.errors();
}

}  // namespace

std::vector<std::string> MarchOptions::Validate() const {
  Requirements r;
  r.Range("min_step", min_step, 1e-6F, 1.0F);
  r.Range("max_step", max_step, min_step, 1.0F);
  r.Range("cone_angle", cone_angle, 0.0F, 1.0F);
  r.Range("min_weight", min_weight, 0.0F, 0.5F);
  r.Range("min_transmittance", min_transmittance, 0.0F, 0.5F);
  r.Range("max_samples", max_samples, 8, 65536);
  return r.errors();
}

std::vector<std::string> FieldOptions::Validate() const {
  Requirements r;
  r.Group("geometry", Violations(geometry));
  r.Group("appearance", Violations(appearance));
  r.Group("background", Violations(background));
  r.Range("density_hidden", density_hidden, 1, 128);
  r.Range("color_hidden", color_hidden, 1, 128);
  r.Range("color_hidden_layers", color_hidden_layers, 1, 3);
  r.Range("direction_degree", direction_degree, 0, 4);
  r.Range("latent_size", latent_size, 0, 32);
  r.Range("occupancy_resolution", occupancy_resolution, 8, 1024);
  return r.errors();
}

std::vector<std::string> TrainOptions::Validate() const {
  Requirements r;
  r.Group("field", field.Validate());
  r.Group("march", march.Validate());
  r.Range("threads", threads, 0, 1024);
  r.Range("patch_px", patch_px, 1, 16);
  r.Range("textured_share", textured_share, 0.0F, 1.0F);
  r.Range("textured_of", textured_of, 1, 1000);
  r.Range("target_samples", target_samples, 1 << 8, 1 << 24);
  r.Range("max_rays", max_rays, 256, 1 << 20);
  r.Range("grid_learning_rate", grid_learning_rate, 0.0F, 1.0F);
  r.Range("grid_epsilon", grid_epsilon, 0.0F, 1.0F);
  r.Range("grid_decay", grid_decay, 0.0F, 1e3F);
  r.Range("network_learning_rate", network_learning_rate, 0.0F, 1.0F);
  r.Range("exposure_learning_rate", exposure_learning_rate, 0.0F, 1.0F);
  r.Range("final_learning_rate", final_learning_rate, 1e-6F, 1.0F);
  r.Range("decay_start", decay_start, 0.0F, 1.0F);
  r.Range("huber_delta", huber_delta, 1e-6F, 1e6F);
  r.Range("depth_weight", depth_weight, 0.0F, 1e3F);
  r.Range("depth_share", depth_share, 0.0F, 0.9F);
  r.Range("final_depth_share", final_depth_share, 0.0F, 0.9F);
  r.Range("carve_votes", carve_votes, 0, 255);
  r.Range("distortion_weight", distortion_weight, 0.0F, 1e3F);
  r.Range("warmup_steps", warmup_steps, 0, 1 << 24);
  r.Range("occupancy_threshold", occupancy_threshold, 1e-6F, 0.9F);
  r.Range("occupancy_interval", occupancy_interval, 1, 1 << 24);
  return r.errors();
}

}  // namespace deja_view::nerf
