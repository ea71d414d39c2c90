#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace deja_view::nerf {

/// A multi-resolution grid of features (Mueller et al., SIGGRAPH 2022, Sec. 3). A level whose cells
/// fit the table is dense, finer ones are hashed.
struct GridOptions {
  int levels = 8;
  int features = 2;             ///< per level: 2 or 4
  int log2_table_size = 19;     ///< entries per level, 2^9 to 2^24
  int base_resolution = 16;     ///< cells of the coarsest level along the longest side
  int finest_resolution = 512;  ///< of the finest level

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("levels", levels);
    v("features", features);
    v("log2_table_size", log2_table_size);
    v("base_resolution", base_resolution);
    v("finest_resolution", finest_resolution);
  }
};

/// Shape of the field: density comes from a coarse grid that every sample reads, radiance from a
/// fine one that only the few samples near a surface read.
struct FieldOptions {
  GridOptions geometry{6, 2, 19, 16, 256};
  GridOptions appearance{6, 4, 21, 64, 2048};
  int density_hidden = 16;      ///< units of the density network's hidden layer, 1 to 128
  int color_hidden = 32;        ///< units per hidden layer of the colour network, 1 to 128
  int color_hidden_layers = 1;  ///< 1 to 3
  int direction_degree = 0;     ///< spherical harmonics up to this degree, 0 (none) to 4
  bool far_background = false;  ///< light from beyond the box, by direction alone
  GridOptions background{4, 4, 15, 8, 64};  ///< over the sphere of directions
  int latent_size = 0;             ///< numbers per image that the colour network may read, 0 to 32
  int occupancy_resolution = 224;  ///< cells along the longest side, 8 to 1024

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("geometry", geometry);
    v("appearance", appearance);
    v("density_hidden", density_hidden);
    v("color_hidden", color_hidden);
    v("color_hidden_layers", color_hidden_layers);
    v("direction_degree", direction_degree);
    v("far_background", far_background);
    v("background", background);
    v("latent_size", latent_size);
    v("occupancy_resolution", occupancy_resolution);
  }

  /// Violations, one line each.
  std::vector<std::string> Validate() const;
};

/// How rays are sampled; lengths are fractions of the longest side of the scene's box.
struct MarchOptions {
  float min_step = 1.0F / 1024;     ///< > 0
  float max_step = 1.0F / 128;      ///< >= min_step
  float cone_angle = 1.0F / 256;    ///< step per distance from the camera, >= 0
  float min_weight = 1e-3F;         ///< lighter samples are given no colour
  float min_transmittance = 1e-3F;  ///< a ray ends where less than this passes
  int max_samples = 256;            ///< per ray

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("min_step", min_step);
    v("max_step", max_step);
    v("cone_angle", cone_angle);
    v("min_weight", min_weight);
    v("min_transmittance", min_transmittance);
    v("max_samples", max_samples);
  }

  /// Violations, one line each.
  std::vector<std::string> Validate() const;
};

/// How a field is trained.
struct TrainOptions {
  FieldOptions field;
  MarchOptions march;
  std::uint64_t seed = 1;
  int threads = 0;               ///< 0: all cores; the result does not depend on it
  std::string kernels = "auto";  ///< "auto", "portable" or a name of AvailableKernels()
  bool deterministic = false;    ///< on a card the same bits every time, more slowly
  int patch_px = 4;              ///< rays come in squares of this side, 1 to 16
  float textured_share = 0.5F;   ///< of the squares, each the one with most contrast of
  int textured_of = 4;           ///< so many: that is where keypoints are
  int target_samples = 1 << 17;  ///< samples per step; the number of rays follows
  int max_rays = 1 << 14;        ///< per step
  float grid_learning_rate = 1e-2F;
  /// What few rays touch, and these lightly, would learn as fast as what many do, and what the rays
  /// of single images taught it shows as fringes: Adam's epsilon holds it still, and the decay (per
  /// learning rate) takes it back (after Barron et al., Zip-NeRF, ICCV 2023, Sec. 5).
  float grid_epsilon = 1e-5F;
  float grid_decay = 0.5F;
  float network_learning_rate = 5e-3F;
  float exposure_learning_rate = 1e-3F;
  float final_learning_rate = 0.05F;  ///< share of the learning rates that is left at the end
  float decay_start = 0.3F;           ///< share of the training after which they decay
  float huber_delta = 0.1F;           ///< [white]; errors above it count linearly
  float depth_weight = 0.7F;          ///< of the loss on depth points
  float depth_share = 0.4F;           ///< of the rays that go through depth points, at the start
  float final_depth_share = 0.2F;     ///< and at the end
  int carve_votes = 10;  ///< depth rays through a cell that make it empty for good; 0: never
  float distortion_weight = 1e-3F;  ///< of the loss that gathers a ray's weights in one place
  bool opaque = true;      ///< what lies in the box lets no light pass; see LossOptions::opaque
  bool exposure = true;    ///< fit a gain and a bias per image
  bool vignetting = true;  ///< fit how the lens darkens towards the border
  int warmup_steps = 128;  ///< short steps before empty space is skipped
  int occupancy_interval = 16;       ///< steps between updates of the occupancy grid
  float occupancy_threshold = 0.1F;  ///< share of the light that a cell must take per shortest step

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("field", field);
    v("march", march);
    v("seed", seed);
    v("threads", threads);
    v("kernels", kernels);
    v("deterministic", deterministic);
    v("patch_px", patch_px);
    v("textured_share", textured_share);
    v("textured_of", textured_of);
    v("target_samples", target_samples);
    v("max_rays", max_rays);
    v("grid_learning_rate", grid_learning_rate);
    v("grid_epsilon", grid_epsilon);
    v("grid_decay", grid_decay);
    v("network_learning_rate", network_learning_rate);
    v("exposure_learning_rate", exposure_learning_rate);
    v("final_learning_rate", final_learning_rate);
    v("decay_start", decay_start);
    v("huber_delta", huber_delta);
    v("depth_weight", depth_weight);
    v("depth_share", depth_share);
    v("final_depth_share", final_depth_share);
    v("carve_votes", carve_votes);
    v("distortion_weight", distortion_weight);
    v("opaque", opaque);
    v("exposure", exposure);
    v("vignetting", vignetting);
    v("warmup_steps", warmup_steps);
    v("occupancy_interval", occupancy_interval);
    v("occupancy_threshold", occupancy_threshold);
  }

  /// Violations, one line each.
  std::vector<std::string> Validate() const;
};

}  // namespace deja_view::nerf
