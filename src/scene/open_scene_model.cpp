#include "deja_view/scene/open_scene_model.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/nerf/field_model.hpp"
#include "deja_view/views/depth_warp_model.hpp"

#include <array>

namespace deja_view {
namespace {

std::shared_ptr<const SceneModel> OpenField(const SceneModelSpec& spec) {
  if (spec.model.empty()) {
    ThrowInputError("--model is missing: expected a radiance field, or --renderer warp");
  }
  if (spec.depth_maps != nullptr) {
    ThrowInputError("--depth-maps: go with --renderer warp only");
  }
  return std::make_shared<nerf::FieldModel>(spec.model, spec.device);
}

std::shared_ptr<const SceneModel> OpenWarp(const SceneModelSpec& spec) {
  const std::shared_ptr<const DepthMaps>& maps = spec.depth_maps;
  if (maps == nullptr) {
    return std::make_shared<DepthWarpModel>(spec.camera, nullptr, "");
  }
  return std::make_shared<DepthWarpModel>(
      spec.camera,
      [maps](std::int64_t stamp_ns) { return maps->Find(stamp_ns); },
      maps->Describe());
}

// A renderer that comes, on another device or of another kind, is a line here.
struct SceneRenderer {
  const char* name;
  std::shared_ptr<const SceneModel> (*open)(const SceneModelSpec& spec);
};
constexpr std::array<SceneRenderer, 2> kRenderers = {{{"nerf", OpenField}, {"warp", OpenWarp}}};

}  // namespace

std::vector<std::string> SceneRenderers() {
  std::vector<std::string> names;
  for (const SceneRenderer& renderer : kRenderers) {
    names.emplace_back(renderer.name);
  }
  return names;
}

std::shared_ptr<const SceneModel> OpenSceneModel(const SceneModelSpec& spec) {
  for (const SceneRenderer& renderer : kRenderers) {
    if (spec.renderer == renderer.name) {
      return renderer.open(spec);
    }
  }
  ThrowInputError(
      "renderer '{}': expected one of {}", spec.renderer, fmt::join(SceneRenderers(), ", "));
}

std::shared_ptr<const SceneModel> OpenSceneModel(const std::filesystem::path& model,
                                                 const nerf::DeviceChoice& device) {
  SceneModelSpec spec;
  spec.model = model;
  spec.device = device;
  return OpenSceneModel(spec);
}

}  // namespace deja_view
