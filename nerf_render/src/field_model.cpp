#include "deja_view/nerf/field_model.hpp"

#include "deja_view/base/hash.hpp"
#include "deja_view/nerf/checkpoint.hpp"

#include <fmt/format.h>

namespace deja_view::nerf {

FieldModel::FieldModel(const std::filesystem::path& path, const DeviceChoice& device)
    : path_(path),
      hash_(Hash64OfFile(path)),
      renderer_(std::make_shared<FieldRenderer>(std::make_shared<RadianceField>(ReadField(path)),
                                                device)) {}

Similarity3 FieldModel::FindFrame(const std::optional<Similarity3>& told) const {
  return told ? *told : RequireFrame(renderer_->field().frame, path_);
}

std::shared_ptr<const ViewRenderer> FieldModel::RendererFor(
    const ViewSource& /*source*/, const std::vector<RangeSample>& /*points*/) const {
  return renderer_;
}

SceneExposure FieldModel::ExposureAt(std::int64_t stamp_ns) const {
  const Exposure exposure = renderer_->ExposureAt(stamp_ns);
  return {exposure.gain, exposure.bias};
}

SceneCells FieldModel::cells() const {
  return renderer_->field().cells;
}

std::string FieldModel::Describe() const {
  return fmt::format("model: {} {:016x}\n", path_.filename().string(), hash_);
}

}  // namespace deja_view::nerf
