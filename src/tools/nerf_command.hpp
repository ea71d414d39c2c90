#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "nerf_input.hpp"
#include <nlohmann/json.hpp>

namespace deja_view {

/// What `deja_view nerf train` is told.
struct NerfTrainRequest {
  NerfInput input;
  std::filesystem::path config;        ///< nerf::TrainOptions
  std::vector<std::string> overrides;  ///< "group.key=value" on top
  std::vector<double> box;             ///< min x y z, max x y z [m]; empty: about the cameras
  std::optional<double> margin;        ///< of that box; nothing: by whether there are points
  bool sparse_points = true;           ///< find points that images share
  double budget_s = 600;               ///< wall time from the start to the model file
  int steps = 0;                       ///< 0: as many as the budget allows
  int threads = 0;
  double checkpoint_s = 60;             ///< wall time between models written on the way; 0: none
  std::filesystem::path resume;         ///< a model to go on with; empty: a new one
  std::filesystem::path refined_poses;  ///< for poses as corrected; empty: not written
  std::filesystem::path out;
  bool show_progress = true;
};

/// What `deja_view nerf eval` is told.
struct NerfEvalRequest {
  NerfInput input;
  std::filesystem::path model;
  std::filesystem::path pictures;  ///< directory for side-by-side pictures; empty: none
  int views = 0;                   ///< 0: all held-out ones
  int threads = 0;
  std::string kernels = "auto";
  bool show_progress = true;
};

/// What `deja_view nerf render` is told.
struct NerfRenderRequest {
  std::filesystem::path model;
  std::filesystem::path camera;
  std::filesystem::path trajectory;  ///< TUM
  std::string poses_of = "body";
  double scale = 1;
  double fps = 10;  ///< pictures per second of the trajectory
  bool depth = false;
  int threads = 0;
  std::filesystem::path out;
  bool show_progress = true;
};

/// Trains a field and writes it; the schedule follows the clock unless `steps` is given, so that
/// only then two runs give the same model. Ctrl-C leaves the model as it is, for `resume`. Returns
/// `steps, rays, samples, psnr_db (over the last training rays), train_wall_s, depth_points,
/// rays_per_s, samples_per_s, interrupted, peak_rss_mb`.
nlohmann::ordered_json RunNerfTrain(const NerfTrainRequest& request);

/// Renders held-out views; returns `psnr_db, ssim, corner_match_rate, views, render_ms_median,
/// peak_rss_mb`. Exposures are those of the training images before and after, not fitted.
nlohmann::ordered_json RunNerfEval(const NerfEvalRequest& request);

/// Writes 000000.png ... along a trajectory; returns `views, render_ms_median, peak_rss_mb`.
nlohmann::ordered_json RunNerfRender(const NerfRenderRequest& request);

/// Reads a model to the last byte; returns what it holds.
nlohmann::ordered_json RunNerfInfo(const std::filesystem::path& path);

}  // namespace deja_view
