#pragma once

#include "deja_view/nerf/device.hpp"
#include "deja_view/scene/depth_maps.hpp"
#include "deja_view/views/scene_model.hpp"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace deja_view {

/// What scene to open, and how to render it. Each renderer takes of this what it needs.
struct SceneModelSpec {
  std::string renderer = "nerf";                ///< one of SceneRenderers()
  std::filesystem::path model;                  ///< a file that the renderer reads
  std::shared_ptr<const Camera> camera;         ///< of the flight's images
  std::shared_ptr<const DepthMaps> depth_maps;  ///< of the flight's images; null: none
  nerf::DeviceChoice device;                    ///< for fields; depth is warped on the CPU
};

/// The names that a spec's renderer may have.
std::vector<std::string> SceneRenderers();

/// Throws InputError for a renderer that nobody knows, for a model that is missing or can't be
/// read, and for what the renderer has no use for; nerf::DeviceError for a card that fails.
std::shared_ptr<const SceneModel> OpenSceneModel(const SceneModelSpec& spec);

/// A model's file alone tells how it is rendered.
std::shared_ptr<const SceneModel> OpenSceneModel(const std::filesystem::path& model,
                                                 const nerf::DeviceChoice& device = {});

}  // namespace deja_view
