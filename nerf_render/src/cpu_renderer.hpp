#pragma once

#include "deja_view/nerf/kernels.hpp"
#include "deja_view/nerf/radiance_field.hpp"
#include "deja_view/views/view_renderer.hpp"

#include "ray_march.hpp"

namespace deja_view::nerf::internal {

/// How fields are sampled to be looked at.
TraceOptions RenderingTrace(const RadianceField& field);

/// A view of the camera's size whose pixels are still to be filled.
RenderedView MakeView(const Camera& camera, int channels);

/// FieldRenderer::Render on the CPU.
RenderedView RenderOnCpu(const RadianceField& field,
                         const Camera& camera,
                         const Rigid3& T_N_C,
                         const ViewRenderOptions& options,
                         const Kernels& kernels);

}  // namespace deja_view::nerf::internal
