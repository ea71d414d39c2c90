#include "deja_view/nerf/field_renderer.hpp"

#include "deja_view/base/check.hpp"

#include <utility>

#include "cpu_renderer.hpp"
#include "device_renderer.hpp"

namespace deja_view::nerf {

FieldRenderer::FieldRenderer(std::shared_ptr<const RadianceField> field, const Kernels& kernels)
    : FieldRenderer(std::move(field), DeviceChoice(), kernels) {}

FieldRenderer::FieldRenderer(std::shared_ptr<const RadianceField> field,
                             const DeviceChoice& device,
                             const Kernels& kernels)
    : field_(std::move(field)), kernels_(&kernels) {
  DEJA_VIEW_CHECK(field_ != nullptr);
  if (!device.IsCpu()) {
    device_ = std::make_unique<internal::DeviceRenderer>(*field_, device);
  }
}

FieldRenderer::~FieldRenderer() = default;

RenderedView FieldRenderer::Render(const Camera& camera,
                                   const Rigid3& T_N_C,
                                   const ViewRenderOptions& options) const {
  return device_ != nullptr ? device_->Render(camera, T_N_C, options)
                            : internal::RenderOnCpu(*field_, camera, T_N_C, options, *kernels_);
}

Exposure FieldRenderer::ExposureAt(std::int64_t stamp_ns) const {
  const Exposure* before = nullptr;
  const Exposure* after = nullptr;
  for (const Exposure& exposure : field_->exposures) {
    if (exposure.stamp_ns == 0) {
      continue;
    }
    if (exposure.stamp_ns <= stamp_ns &&
        (before == nullptr || exposure.stamp_ns > before->stamp_ns)) {
      before = &exposure;
    }
    if (exposure.stamp_ns >= stamp_ns &&
        (after == nullptr || exposure.stamp_ns < after->stamp_ns)) {
      after = &exposure;
    }
  }
  if (before == nullptr || after == nullptr) {
    const Exposure* nearest = before != nullptr ? before : after;
    return nearest != nullptr && stamp_ns != 0 ? *nearest : Exposure{};
  }
  const auto span = static_cast<float>(after->stamp_ns - before->stamp_ns);
  const float u = span > 0 ? static_cast<float>(stamp_ns - before->stamp_ns) / span : 0.0F;
  Exposure result;
  result.stamp_ns = stamp_ns;
  result.gain = before->gain + u * (after->gain - before->gain);
  result.bias = before->bias + u * (after->bias - before->bias);
  return result;
}

}  // namespace deja_view::nerf
