#include "deja_view/nerf/field_renderer.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ray_tracer.hpp"

namespace deja_view::nerf {
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
  std::vector<internal::Ray> rays;
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
      rays.push_back(internal::MakeRay(field, T_N_C.t, R_N_C * direction_C, 0.5F));
      along_axis.push_back(static_cast<float>(direction_C.z()));
    }
  }
}

std::uint8_t ToGrey(float value) {
  return static_cast<std::uint8_t>(std::clamp(255 * value + 0.5F, 0.0F, 255.0F));
}

// Sums over the samples of one ray.
void WritePixel(const internal::Trace& trace,
                std::size_t ray,
                const RadianceField& field,
                const ViewRenderOptions& options,
                float vignetting,
                cv::Point pixel,
                RenderedView* view) {
  const auto channels = static_cast<std::size_t>(field.channels);
  const auto size = static_cast<float>(field.box.Size());
  float color[3] = {};
  float sum = 0;
  float sum_t = 0;
  float sum_t2 = 0;
  for (std::size_t s = trace.ray_begin[ray]; s < trace.ray_begin[ray + 1]; ++s) {
    const float w = trace.weight[s];
    sum += w;
    sum_t += w * trace.t[s];
    for (std::size_t c = 0; c < channels; ++c) {
      color[c] += w * trace.color[s * channels + c];
    }
  }
  for (std::size_t c = 0; c < channels && !trace.background.empty(); ++c) {
    color[c] += trace.transmittance[ray] * trace.background[ray * channels + c];
  }
  const float mean = sum > 0 ? sum_t / sum : 0.0F;
  for (std::size_t s = trace.ray_begin[ray]; s < trace.ray_begin[ray + 1]; ++s) {
    sum_t2 += trace.weight[s] * (trace.t[s] - mean) * (trace.t[s] - mean);
  }
  const float gain = options.gain * vignetting;
  std::uint8_t* out = view->image.ptr(pixel.y) + static_cast<std::size_t>(pixel.x) * channels;
  for (std::size_t c = 0; c < channels; ++c) {
    out[c] = ToGrey(gain * color[c] + options.bias);
  }
  view->depth.at<float>(pixel) = mean * size;
  view->depth_variance.at<float>(pixel) = sum > 0 ? sum_t2 / sum * size * size : 0.0F;
  view->opacity.at<float>(pixel) = std::min(1.0F, sum);
}

}  // namespace

FieldRenderer::FieldRenderer(std::shared_ptr<const RadianceField> field, const Kernels& kernels)
    : field_(std::move(field)), kernels_(&kernels) {
  DEJA_VIEW_CHECK(field_ != nullptr);
}

RenderedView FieldRenderer::Render(const Camera& camera,
                                   const Rigid3& T_N_C,
                                   const ViewRenderOptions& options) const {
  RenderedView view;
  view.image.create(camera.height(), camera.width(), field_->channels == 1 ? CV_8UC1 : CV_8UC3);
  view.depth.create(camera.height(), camera.width(), CV_32FC1);
  view.depth_variance.create(camera.height(), camera.width(), CV_32FC1);
  view.opacity.create(camera.height(), camera.width(), CV_32FC1);
  const std::vector<Tile> tiles = MakeTiles(camera);
  internal::TraceOptions trace_options;
  trace_options.march = field_->march;
  trace_options.march.min_transmittance =
      std::max(kLeastTransmittance, field_->march.min_transmittance);
  ParallelFor(
      options.threads,
      tiles.size(),
      [&](std::size_t begin, std::size_t end) {
        internal::RayTracer tracer(*field_, *kernels_);
        internal::Trace trace;
        TileRays tile_rays;
        for (std::size_t i = begin; i < end; ++i) {
          const Tile& tile = tiles[i];
          tile_rays.Make(*field_, camera, T_N_C, tile);
          tracer.Run(tile_rays.rays, trace_options, &trace);
          std::size_t ray = 0;
          for (int y = tile.y; y < tile.y + tile.height; ++y) {
            for (int x = tile.x; x < tile.x + tile.width; ++x) {
              const float vignetting =
                  options.vignetting ? field_->vignetting.At(1 - tile_rays.along_axis[ray]) : 1.0F;
              WritePixel(trace, ray++, *field_, options, vignetting, {x, y}, &view);
            }
          }
        }
      },
      8);
  return view;
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
