#pragma once

#include "deja_view/nerf/device.hpp"
#include "deja_view/nerf/radiance_field.hpp"
#include "deja_view/views/view_renderer.hpp"

#include <memory>
#include <mutex>

#include "device_batches.hpp"
#include "device_engine.hpp"

namespace deja_view::nerf::internal {

/// Renders a field on a card.
class DeviceRenderer {
 public:
  /// Takes the field to the card. Throws DeviceError, also for a card that does not show of this
  /// field what the CPU does. The field must live on, and not change.
  DeviceRenderer(const RadianceField& field, const DeviceChoice& device);

  /// As FieldRenderer::Render. One view at a time, from any thread. Throws DeviceError.
  RenderedView Render(const Camera& camera,
                      const Rigid3& T_N_C,
                      const ViewRenderOptions& options) const;

 private:
  const RadianceField& field_;
  mutable std::mutex mutex_;
  std::unique_ptr<DeviceEngine> engine_;
  mutable DeviceBatches batches_;
};

/// Opens the card and takes the field there. Throws DeviceError.
std::unique_ptr<DeviceEngine> OpenDevice(const RadianceField& field, const DeviceChoice& device);

/// Renders with an engine that has the field; `batches` says how many pixels at a time.
RenderedView RenderOnDevice(const RadianceField& field,
                            const Camera& camera,
                            const Rigid3& T_N_C,
                            const ViewRenderOptions& options,
                            DeviceEngine* engine,
                            DeviceBatches* batches);

/// Throws DeviceError where the engine does not show of the field what the CPU does.
void CheckAgainstCpu(const RadianceField& field, DeviceEngine* engine, DeviceBatches* batches);

}  // namespace deja_view::nerf::internal
