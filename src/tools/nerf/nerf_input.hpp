#pragma once

#include "deja_view/nerf/posed_images.hpp"
#include "deja_view/nerf/trainer.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace deja_view {

/// Where posed images come from, and how they are taken. Exactly one of images (alone), transforms,
/// colmap, seven_scenes and bag is given.
struct NerfInput {
  std::filesystem::path images;  ///< directory of <stamp>.<extension>, or COLMAP's images
  std::filesystem::path camera;  ///< of ReadVinsConfig; of 7-Scenes: the colour camera's, or none
  std::filesystem::path poses;   ///< ReadTrajectoryFile, or a bag
  std::string poses_of = "body";
  std::filesystem::path transforms;    ///< transforms.json
  std::filesystem::path colmap;        ///< model
  std::filesystem::path seven_scenes;  ///< directory
  std::filesystem::path bag;
  std::string image_topic;       ///< empty: the camera file's
  std::string pose_topic;        ///< in `poses` if that is a bag, otherwise in `bag`
  std::filesystem::path points;  ///< VINS-Mono's bag; empty: no depth points but the input's own
  bool skip_missing = false;     ///< leave out images without pose and poses without image
  int every = 1;                 ///< take every N-th image
  int holdout = 20;              ///< every N-th of these is held out; 0: none
  double scale = 1;              ///< of the images against their files, at most 1
  int max_side = 0;              ///< shrink to this longest side [px]; 0: as they are
  bool grey = false;             ///< one channel, even of colour images
};

/// The images with their poses, split; none is decoded. Throws InputError, also for sources that
/// don't go together.
nerf::Split ReadNerfInput(const NerfInput& input);

/// Where the poses' frame lies: structure from motion knows no scale.
nerf::FieldFrame FrameOf(const NerfInput& input);

/// How the images are decoded, as grey levels.
nerf::LoadOptions MakeLoadOptions(const NerfInput& input, int threads);

/// Decodes images of the input to train on. Throws InputError.
std::vector<nerf::TrainingView> LoadTrainingViews(const NerfInput& input,
                                                  const std::vector<nerf::PosedImage>& images,
                                                  int threads);

}  // namespace deja_view
