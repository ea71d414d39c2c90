#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace deja_view {

/// The images of a bag's topic, still without poses; they are decoded when they are wanted. Throws
/// InputError.
std::vector<nerf::PosedImage> ListBagInput(const std::filesystem::path& bag,
                                           const std::string& topic,
                                           const std::shared_ptr<const Camera>& camera);

/// The keyframes with points that VINS-Mono put in a bag. Throws InputError.
std::vector<nerf::VioKeyframe> ReadBagKeyframes(const std::filesystem::path& bag);

}  // namespace deja_view
