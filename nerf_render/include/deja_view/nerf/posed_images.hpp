#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/geometry/trajectory.hpp"
#include "deja_view/nerf/trainer.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace deja_view::nerf {

/// An image file with its camera, at the file's own size, and its pose.
struct PosedImage {
  std::filesystem::path path;
  std::string name;           ///< within its data set
  std::int64_t stamp_ns = 0;  ///< 0: unknown
  std::shared_ptr<const Camera> camera;
  Rigid3 T_N_C;
};

/// Image files of a directory, without its subdirectories, sorted by name. Throws InputError that
/// names the directory when it can't be read or holds no image.
std::vector<std::filesystem::path> ListImages(const std::filesystem::path& directory);

/// Images named <stamp in ns>.<extension> in `directory`, with the poses that `T_N_B` has at their
/// stamps, interpolated over at most 0.1 s; T_B_C is the identity for a trajectory of the camera.
/// N is the trajectory's world. Throws InputError that names the file for a name that is no stamp,
/// and with counts when images lack a pose.
std::vector<PosedImage> ReadTrajectoryImages(const std::filesystem::path& directory,
                                             std::shared_ptr<const Camera> camera,
                                             const Rigid3& T_B_C,
                                             const Trajectory& T_N_B);

/// Decodes images, as grey levels where `channels` is 1, and shrinks them and their cameras by
/// `scale` (at most 1; area means). Throws InputError that names a file that can't be decoded or
/// has another size than its camera.
std::vector<TrainingView> LoadViews(const std::vector<PosedImage>& images,
                                    int channels,
                                    double scale,
                                    int threads);

/// Every `every`-th image, from the first on, for evaluation; the others for training. 0: none.
struct Split {
  std::vector<PosedImage> training;
  std::vector<PosedImage> held_out;
};
Split HoldOut(const std::vector<PosedImage>& images, int every);

}  // namespace deja_view::nerf
