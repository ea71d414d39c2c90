#include "deja_view/nerf/options.hpp"

#include <fmt/format.h>

namespace deja_view::nerf {
namespace {

class Violations {
 public:
  template <typename T>
  void Range(const char* key, T value, T low, T high) {
    if (!(value >= low && value <= high)) {
      list.push_back(fmt::format("{}: {} is not in [{}, {}]", key, value, low, high));
    }
  }
  void Grid(const char* group, const GridOptions& grid) {
    const std::string prefix = std::string(group) + ".";
    Range((prefix + "levels").c_str(), grid.levels, 1, 24);
    if (grid.features != 2 && grid.features != 4) {
      list.push_back(fmt::format("{}features: {} is neither 2 nor 4", prefix, grid.features));
    }
    Range((prefix + "log2_table_size").c_str(), grid.log2_table_size, 9, 24);
    Range((prefix + "base_resolution").c_str(), grid.base_resolution, 2, 16384);
    Range((prefix + "finest_resolution").c_str(),
          grid.finest_resolution,
          grid.base_resolution,
          65536);
  }
  std::vector<std::string> list;
};

void CheckMarch(const MarchOptions& march, Violations* v) {
  v->Range("march.min_step", march.min_step, 1e-6F, 1.0F);
  v->Range("march.max_step", march.max_step, march.min_step, 1.0F);
  v->Range("march.cone_angle", march.cone_angle, 0.0F, 1.0F);
  v->Range("march.min_weight", march.min_weight, 0.0F, 0.5F);
  v->Range("march.min_transmittance", march.min_transmittance, 0.0F, 0.5F);
  v->Range("march.max_samples", march.max_samples, 8, 65536);
}

}  // namespace

std::vector<std::string> FieldOptions::Validate() const {
  Violations v;
  v.Grid("geometry", geometry);
  v.Grid("appearance", appearance);
  v.Grid("background", background);
  v.Range("density_hidden", density_hidden, 1, 128);
  v.Range("color_hidden", color_hidden, 1, 128);
  v.Range("color_hidden_layers", color_hidden_layers, 1, 3);
  v.Range("direction_degree", direction_degree, 0, 4);
  v.Range("latent_size", latent_size, 0, 32);
  v.Range("occupancy_resolution", occupancy_resolution, 8, 1024);
  return v.list;
}

std::vector<std::string> TrainOptions::Validate() const {
  Violations v;
  for (const std::string& violation : field.Validate()) {
    v.list.push_back("field." + violation);
  }
  CheckMarch(march, &v);
  v.Range("threads", threads, 0, 1024);
  v.Range("patch_px", patch_px, 1, 16);
  v.Range("target_samples", target_samples, 1 << 8, 1 << 24);
  v.Range("max_rays", max_rays, 256, 1 << 20);
  v.Range("grid_learning_rate", grid_learning_rate, 0.0F, 1.0F);
  v.Range("network_learning_rate", network_learning_rate, 0.0F, 1.0F);
  v.Range("exposure_learning_rate", exposure_learning_rate, 0.0F, 1.0F);
  v.Range("final_learning_rate", final_learning_rate, 1e-6F, 1.0F);
  v.Range("decay_start", decay_start, 0.0F, 1.0F);
  v.Range("huber_delta", huber_delta, 1e-6F, 1e6F);
  v.Range("depth_weight", depth_weight, 0.0F, 1e3F);
  v.Range("depth_share", depth_share, 0.0F, 0.9F);
  v.Range("final_depth_share", final_depth_share, 0.0F, 0.9F);
  v.Range("carve_votes", carve_votes, 0, 255);
  v.Range("distortion_weight", distortion_weight, 0.0F, 1e3F);
  v.Range("pose_learning_rate", pose_learning_rate, 0.0F, 1.0F);
  v.Range("warmup_steps", warmup_steps, 0, 1 << 24);
  v.Range("occupancy_threshold", occupancy_threshold, 1e-6F, 0.9F);
  v.Range("occupancy_interval", occupancy_interval, 1, 1 << 24);
  return v.list;
}

}  // namespace deja_view::nerf
