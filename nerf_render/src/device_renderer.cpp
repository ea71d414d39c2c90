#include "device_renderer.hpp"

#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "cpu_renderer.hpp"
#include "plain_field.hpp"
#include <fmt/format.h>

namespace deja_view::nerf::internal {
namespace {

PixelArrays PixelsFrom(std::size_t first, RenderedView* view) {
  const auto channels = static_cast<std::size_t>(view->image.channels());
  return {view->image.ptr() + first * channels,
          view->depth.ptr<float>() + first,
          view->depth_variance.ptr<float>() + first,
          view->opacity.ptr<float>() + first};
}

// Pixels whose image or depth is not the same but for rounding.
int CountDifferences(const RenderedView& a, const RenderedView& b) {
  constexpr int kMostLevels = 1;
  constexpr float kMostDepth = 5e-3F;
  const std::size_t pixels = a.depth.total();
  const auto channels = static_cast<std::size_t>(a.image.channels());
  int count = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    const float depth_a = a.depth.ptr<float>()[i];
    const float depth_b = b.depth.ptr<float>()[i];
    bool differs = !(std::abs(depth_a - depth_b) <= kMostDepth * std::max(depth_a, depth_b));
    for (std::size_t c = i * channels; c < (i + 1) * channels; ++c) {
      differs = differs || std::abs(a.image.ptr()[c] - b.image.ptr()[c]) > kMostLevels;
    }
    count += differs ? 1 : 0;
  }
  return count;
}

PinholeCamera CheckCamera() {
  PinholeParameters parameters;
  parameters.width = 32;
  parameters.height = 24;
  parameters.fx = parameters.fy = 16;
  parameters.cx = 15.5;
  parameters.cy = 11.5;
  parameters.k1 = -0.1;
  return PinholeCamera(parameters);
}

}  // namespace

std::unique_ptr<DeviceEngine> OpenDevice(const RadianceField& field, const DeviceChoice& device) {
  std::unique_ptr<DeviceEngine> engine = device.platform->Open(device.card);
  DeviceBatches batches(engine->Name(), field.march, BytesOf(field));
  batches.Try([&] { engine->LoadField(LayoutOf(field), ArraysOf(field)); }, [] {});
  CheckAgainstCpu(field, engine.get(), &batches);
  return engine;
}

RenderedView RenderOnDevice(const RadianceField& field,
                            const Camera& camera,
                            const Rigid3& T_N_C,
                            const ViewRenderOptions& options,
                            DeviceEngine* engine,
                            DeviceBatches* batches) {
  RenderedView view = MakeView(camera, field.channels);
  RenderJob job;
  job.lens = LensOf(camera);
  job.width = camera.width();
  job.T_N_C = PlainPoseOf(T_N_C);
  job.trace = RenderingTrace(field);
  job.gain = options.gain;
  job.bias = options.bias;
  job.vignetting = options.vignetting;
  job.vignetting_k = field.vignetting.k;
  const std::size_t pixels = view.depth.total();
  for (std::size_t first = 0; first < pixels;) {
    std::size_t count = 0;
    batches->Try(
        [&] {
          count = std::min(batches->size(), pixels - first);
          engine->Render(job, first, count, PixelsFrom(first, &view));
        },
        [] {});
    first += count;
  }
  return view;
}

void CheckAgainstCpu(const RadianceField& field, DeviceEngine* engine, DeviceBatches* batches) {
  const PinholeCamera camera = CheckCamera();
  constexpr int kMostOf768 = 8;
  // From the middle of the box, each way.
  for (const double angle : {0.0, 2.1, 4.2}) {
    const Rigid3 T_N_C{ExpSo3({0.3, angle, 0.1}), 0.5 * (field.box.min + field.box.max)};
    const RenderedView expected = RenderOnCpu(field, camera, T_N_C, {}, PortableKernels());
    const RenderedView found = RenderOnDevice(field, camera, T_N_C, {}, engine, batches);
    const int differences = CountDifferences(expected, found);
    if (differences > kMostOf768) {
      throw DeviceError(fmt::format(
          "{}: {} of {} pixels of a check are not what the CPU shows: the card is not used",
          engine->Name(),
          differences,
          expected.depth.total()));
    }
  }
}

DeviceRenderer::DeviceRenderer(const RadianceField& field, const DeviceChoice& device)
    : field_(field),
      engine_(OpenDevice(field, device)),
      batches_(engine_->Name(), field.march, BytesOf(field)) {}

RenderedView DeviceRenderer::Render(const Camera& camera,
                                    const Rigid3& T_N_C,
                                    const ViewRenderOptions& options) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return RenderOnDevice(field_, camera, T_N_C, options, engine_.get(), &batches_);
}

}  // namespace deja_view::nerf::internal
