#pragma once

#include "deja_view/nerf/field_renderer.hpp"
#include "deja_view/views/scene_model.hpp"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace deja_view::nerf {

/// A radiance field as the model of a scene.
class FieldModel final : public SceneModel {
 public:
  /// Reads what WriteField wrote, to render it on `device`. Throws InputError that names the file,
  /// DeviceError for a card that fails.
  explicit FieldModel(const std::filesystem::path& path, const DeviceChoice& device = {});

  Similarity3 FindFrame(const std::optional<Similarity3>& told) const override;
  /// The same for all sources.
  std::shared_ptr<const ViewRenderer> RendererFor(
      const ViewSource& source, const std::vector<RangeSample>& points) const override;
  SceneExposure ExposureAt(std::int64_t stamp_ns) const override;
  SceneCells cells() const override;
  std::string Describe() const override;

 private:
  std::filesystem::path path_;
  std::uint64_t hash_ = 0;  ///< of the file
  std::shared_ptr<const FieldRenderer> renderer_;
};

}  // namespace deja_view::nerf
