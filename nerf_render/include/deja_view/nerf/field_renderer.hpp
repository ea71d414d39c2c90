#pragma once

#include "deja_view/nerf/device.hpp"
#include "deja_view/nerf/kernels.hpp"
#include "deja_view/nerf/radiance_field.hpp"
#include "deja_view/views/view_renderer.hpp"

#include <memory>

namespace deja_view::nerf {

namespace internal {
class DeviceRenderer;
}

/// Renders a trained field. The same bits for any number of threads.
class FieldRenderer final : public ViewRenderer {
 public:
  explicit FieldRenderer(std::shared_ptr<const RadianceField> field,
                         const Kernels& kernels = FindKernels("auto"));
  /// On a card the views differ from the CPU's by rounding. Throws DeviceError, now or in Render.
  FieldRenderer(std::shared_ptr<const RadianceField> field,
                const DeviceChoice& device,
                const Kernels& kernels = FindKernels("auto"));
  ~FieldRenderer() override;

  RenderedView Render(const Camera& camera,
                      const Rigid3& T_N_C,
                      const ViewRenderOptions& options) const override;

  const RadianceField& field() const { return *field_; }

  /// Gain and bias of an image that was not trained on, between those of the training images before
  /// and after its stamp; of the nearest at the ends, and the neutral one where no stamp is known.
  Exposure ExposureAt(std::int64_t stamp_ns) const;

 private:
  std::shared_ptr<const RadianceField> field_;
  const Kernels* kernels_;
  std::unique_ptr<const internal::DeviceRenderer> device_;  ///< null: the CPU
};

}  // namespace deja_view::nerf
