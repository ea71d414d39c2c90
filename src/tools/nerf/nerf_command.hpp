#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "nerf/nerf_input.hpp"
#include <nlohmann/json.hpp>

namespace CLI {
class App;
}

namespace deja_view {

/// What `deja_view nerf train` is told.
struct NerfTrainRequest {
  NerfInput input;
  std::filesystem::path config;        ///< nerf::TrainOptions
  std::vector<std::string> overrides;  ///< "group.key=value" on top
  std::vector<double> box;             ///< min x y z, max x y z [m]; empty: about the cameras
  std::optional<double> margin;        ///< of that box; times its diagonal; nothing: DefaultMargin
  bool sparse_points = true;           ///< find points that images share
  double budget_s = 600;               ///< wall time from the start to the model file
  int steps = 0;                       ///< 0: as many as the budget allows
  int threads = 0;
  std::string device = "auto";       ///< nerf::ChooseDevice
  double checkpoint_s = 60;          ///< wall time between models written on the way; 0: none
  std::filesystem::path resume;      ///< a model to go on with; empty: a new one
  std::filesystem::path start_from;  ///< a trained model to learn more from; empty: a new one
  std::vector<NerfInput> more;       ///< of the same place, in the same frame; decoded as `input`
  std::string shard;                 ///< sub-map i of n, "i/n"; empty: all in one field
  std::filesystem::path out;
  bool show_progress = true;
};

/// What `deja_view nerf eval` is told.
struct NerfEvalRequest {
  NerfInput input;
  std::filesystem::path model;
  std::filesystem::path pictures;  ///< directory for side-by-side pictures; empty: none
  int views = 0;                   ///< 0: all held-out ones
  std::string shard;               ///< only those of a sub-map; empty: those of the model's
  int threads = 0;
  std::string device = "auto";
  std::string kernels = "auto";
  bool show_progress = true;
};

/// What `deja_view nerf render` is told.
struct NerfRenderRequest {
  std::filesystem::path model;
  std::filesystem::path transforms;  ///< instead of camera and trajectory
  std::filesystem::path camera;      ///< of ReadVinsConfig
  std::filesystem::path trajectory;  ///< ReadTrajectoryFile
  std::string poses_of = "body";
  double scale = 1;
  double fps = 10;  ///< pictures per second of the trajectory
  bool depth = false;
  int threads = 0;
  std::string device = "auto";
  std::filesystem::path out;
  bool show_progress = true;
};

/// What `deja_view nerf align` is told.
struct NerfAlignRequest {
  std::filesystem::path model;
  std::string poses;  ///< ReadPoses: those that the model was trained on
  std::string poses_of = "body";
  std::string align_to;          ///< ReadPoses, of the body, in metres
  std::filesystem::path camera;  ///< of ReadVinsConfig
  double max_rmse_m = 0.2;
  std::filesystem::path out;
};

/// What `deja_view nerf compare-poses` is told.
struct NerfCompareRequest {
  NerfInput input;  ///< images, camera and how they are taken; its poses are not used
  std::vector<std::string> sources;         ///< NAME=FILE or NAME=BAG:/topic
  std::vector<std::string> camera_sources;  ///< of the camera, not of the body
  std::string reference;                    ///< FILE or BAG:/topic to align to; empty: no alignment
  std::filesystem::path config;             ///< nerf::TrainOptions
  std::vector<std::string> overrides;       ///< "group.key=value" on top
  int steps = 1000;                         ///< of each training
  int threads = 0;
  std::filesystem::path pictures;  ///< directory for side-by-side pictures; empty: none
  bool show_progress = true;
};

/// Adds the options that say where posed images come from.
void AddNerfInputOptions(CLI::App* sub, NerfInput* input);

/// Trains a field and writes it; the schedule follows the clock unless `steps` is given, so that
/// only then two runs give the same model. Ctrl-C leaves the model as it is, for `resume`. With
/// `start_from` the images outside of that model's box are left out. Returns `shard, images,
/// images_outside (with start_from), steps, rays, samples, psnr_db (over the last training rays),
/// train_wall_s, depth_points, rays_per_s, samples_per_s, interrupted, peak_device_mb (0 on the
/// CPU), peak_rss_mb`. Throws DeviceLostError that tells what is kept where a card is lost.
nlohmann::ordered_json RunNerfTrain(const NerfTrainRequest& request);

/// Renders held-out views; returns `psnr_db, ssim, corner_match_rate, corner_match_ceiling, views,
/// depth_rel_err_median (over all pixels of nerf::Split's held_out and depth_checks that have a
/// true depth; null without any), depth_views, render_ms_median, peak_rss_mb`. Exposures are those
/// of the training images before and after, not fitted.
nlohmann::ordered_json RunNerfEval(const NerfEvalRequest& request);

/// Trains a short field per source of poses, on the same images with the same steps, and compares
/// held-out views rendered at the source's own poses: the paper's Table 2. Images count that all
/// sources have a pose for. Returns `images, steps, sources: [{name, file, psnr_db, ssim,
/// corner_match_rate, views, train_wall_s, alignment: {rmse_m, max_m, inlier_share, rotation_deg,
/// scale}}]`.
nlohmann::ordered_json RunNerfComparePoses(const NerfCompareRequest& request);

/// Writes 000000.png ... along a trajectory; returns `views, render_ms_median, peak_rss_mb`.
nlohmann::ordered_json RunNerfRender(const NerfRenderRequest& request);

/// Writes the model again, with its place among poses in metres. Returns `model, alignment`.
nlohmann::ordered_json RunNerfAlign(const NerfAlignRequest& request);

/// Reads a model to the last byte; returns what it holds, and what could render it: the latter
/// alone where the path is empty.
nlohmann::ordered_json RunNerfInfo(const std::filesystem::path& path);

}  // namespace deja_view
