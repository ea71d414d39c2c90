#pragma once

#include "deja_view/nerf/posed_images.hpp"
#include "deja_view/nerf/trainer.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace deja_view {

/// Where posed images come from, and how they are taken.
struct NerfInput {
  std::filesystem::path images;  ///< directory of <stamp ns>.<extension>
  std::filesystem::path camera;  ///< VINS-Mono's YAML
  std::filesystem::path poses;   ///< TUM
  std::string poses_of = "body";
  int holdout = 20;    ///< every N-th image is held out; 0: none
  double scale = 1;    ///< of the images against their files, at most 1
  bool color = false;  ///< three channels
};

/// The images with their poses, split; none is decoded. Throws InputError.
nerf::Split ReadNerfInput(const NerfInput& input);

/// The decoded images that are not held out. Throws InputError.
std::vector<nerf::TrainingView> LoadTrainingViews(const NerfInput& input, int threads);

}  // namespace deja_view
