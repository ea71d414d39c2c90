#include "cpu_renderer.hpp"

#include "deja_view/base/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pixel_sum.hpp"
#include "ray_tracer.hpp"

namespace deja_view::nerf::internal {
namespace {

constexpr int kTile = 16;  ///< [px]; neighbouring rays read the same cells

// Less light than eight bits can show.
constexpr float kLeastTransmittance = 1.0F / 256;

struct Tile {
  int x, y, width, height;
};

std::vector<Tile> MakeTiles(const Camera& camera) {
  std::vector<Tile> tiles;
  for (int y = 0; y < camera.height(); y += kTile) {
    for (int x = 0; x < camera.width(); x += kTile) {
      tiles.push_back(
          {x, y, std::min(kTile, camera.width() - x), std::min(kTile, camera.height() - y)});
    }
  }
  return tiles;
}

/// The rays of a tile's pixels, row by row.
struct TileRays {
  std::vector<Ray> rays;
  std::vector<float> along_axis;  ///< cosine to the optical axis

  void Make(const RadianceField& field,
            const Camera& camera,
            const Rigid3& T_N_C,
            const Tile& tile);
};

void TileRays::Make(const RadianceField& field,
                    const Camera& camera,
                    const Rigid3& T_N_C,
                    const Tile& tile) {
  const Eigen::Matrix3d R_N_C = T_N_C.R();
  rays.clear();
  along_axis.clear();
  for (int y = tile.y; y < tile.y + tile.height; ++y) {
    for (int x = tile.x; x < tile.x + tile.width; ++x) {
      const Eigen::Vector3d direction_C = camera.Unproject({x, y});
      rays.push_back(MakeRay(field, T_N_C.t, R_N_C * direction_C, 0.5F));
      along_axis.push_back(static_cast<float>(direction_C.z()));
    }
  }
}

void WritePixel(const PixelValues& values, cv::Point pixel, RenderedView* view) {
  const auto channels = static_cast<std::size_t>(view->image.channels());
  std::uint8_t* out = view->image.ptr(pixel.y) + static_cast<std::size_t>(pixel.x) * channels;
  std::copy_n(values.color.begin(), channels, out);
  view->depth.at<float>(pixel) = values.depth;
  view->depth_variance.at<float>(pixel) = values.depth_variance;
  view->opacity.at<float>(pixel) = values.opacity;
}

// A trace as the sums over a pixel's samples see it.
TraceView ViewOf(const Trace& trace, int channels) {
  TraceView view;
  view.ray_begin = trace.ray_begin.data();
  view.t = trace.t.data();
  view.weight = trace.weight.data();
  view.color = trace.color.data();
  view.transmittance = trace.transmittance.data();
  view.background = trace.background.empty() ? nullptr : trace.background.data();
  view.channels = static_cast<std::size_t>(channels);
  return view;
}

}  // namespace

TraceOptions RenderingTrace(const RadianceField& field) {
  TraceOptions options;
  options.march = field.march;
  options.march.min_transmittance = std::max(kLeastTransmittance, field.march.min_transmittance);
  return options;
}

RenderedView MakeView(const Camera& camera, int channels) {
  RenderedView view;
  view.image.create(camera.height(), camera.width(), channels == 1 ? CV_8UC1 : CV_8UC3);
  view.depth.create(camera.height(), camera.width(), CV_32FC1);
  view.depth_variance.create(camera.height(), camera.width(), CV_32FC1);
  view.opacity.create(camera.height(), camera.width(), CV_32FC1);
  return view;
}

RenderedView RenderOnCpu(const RadianceField& field,
                         const Camera& camera,
                         const Rigid3& T_N_C,
                         const ViewRenderOptions& options,
                         const Kernels& kernels) {
  RenderedView view = MakeView(camera, field.channels);
  const std::vector<Tile> tiles = MakeTiles(camera);
  const TraceOptions trace_options = RenderingTrace(field);
  ParallelFor(
      options.threads,
      tiles.size(),
      [&](std::size_t begin, std::size_t end) {
        RayTracer tracer(field, kernels);
        Trace trace;
        TileRays tile_rays;
        for (std::size_t i = begin; i < end; ++i) {
          const Tile& tile = tiles[i];
          tile_rays.Make(field, camera, T_N_C, tile);
          tracer.Run(tile_rays.rays, trace_options, &trace);
          const PixelSum sum{ViewOf(trace, field.channels),
                             static_cast<float>(field.box.Size()),
                             options.gain,
                             options.bias};
          std::size_t ray = 0;
          for (int y = tile.y; y < tile.y + tile.height; ++y) {
            for (int x = tile.x; x < tile.x + tile.width; ++x) {
              const float vignetting =
                  options.vignetting ? field.vignetting.At(1 - tile_rays.along_axis[ray]) : 1.0F;
              WritePixel(sum(ray++, vignetting), {x, y}, &view);
            }
          }
        }
      },
      8);
  return view;
}

}  // namespace deja_view::nerf::internal
