#include "deja_view/sim/renderer.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"
#include "deja_view/sim/light.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace deja_view::sim {
namespace {

/// Places within a pixel that cover it evenly for any count: the R2 sequence (Roberts, 2018).
Eigen::Vector2d SampleOffset(int index) {
  constexpr double kA = 0.7548776662466927;
  constexpr double kB = 0.5698402909980532;
  const double x = 0.5 + kA * (index + 1);
  const double y = 0.5 + kB * (index + 1);
  return {x - std::floor(x) - 0.5, y - std::floor(y) - 0.5};
}

}  // namespace

Renderer::Renderer(std::shared_ptr<const World> world,
                   std::shared_ptr<const Camera> camera,
                   int samples,
                   int threads)
    : world_(std::move(world)), camera_(std::move(camera)), samples_(samples), threads_(threads) {
  DEJA_VIEW_CHECK(world_ != nullptr && camera_ != nullptr);
  DEJA_VIEW_CHECK(samples >= 1 && samples <= 64);
  pixel_angle_ = static_cast<float>(1.0 / (camera_->FocalLength() * std::sqrt(samples)));
  centre_rays_ = MakeRays(Eigen::Vector2d::Zero());
  for (int i = 0; i < samples; ++i) {
    sample_rays_.push_back(samples == 1 ? centre_rays_ : MakeRays(SampleOffset(i)));
  }
  MakeBeams();
}

Renderer::RayTable Renderer::MakeRays(const Eigen::Vector2d& offset) const {
  const int width = camera_->width();
  const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(camera_->height());
  RayTable rays;
  rays.x.resize(count);
  rays.y.resize(count);
  rays.z.resize(count);
  ParallelFor(
      threads_,
      static_cast<std::size_t>(camera_->height()),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
          for (int x = 0; x < width; ++x) {
            const Eigen::Vector2d pixel(x + offset.x(), static_cast<double>(y) + offset.y());
            const Eigen::Vector3f ray = camera_->Unproject(pixel).cast<float>();
            const std::size_t i = y * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
            rays.x[i] = ray.x();
            rays.y[i] = ray.y();
            rays.z[i] = ray.z();
          }
        }
      },
      16);
  return rays;
}

Renderer::Beam Renderer::MakeBeam(int x, int y, int size) const {
  Beam beam{x, y, std::min(size, camera_->width() - x), std::min(size, camera_->height() - y), {}};
  std::vector<Eigen::Vector3f> border;
  const auto add = [&](int px, int py) {
    const auto i = static_cast<std::size_t>(py) * static_cast<std::size_t>(camera_->width()) +
                   static_cast<std::size_t>(px);
    border.emplace_back(centre_rays_.x[i], centre_rays_.y[i], centre_rays_.z[i]);
  };
  for (int i = 0; i < beam.width; ++i) {
    add(x + i, y);
    add(x + i, y + beam.height - 1);
  }
  for (int i = 0; i < beam.height; ++i) {
    add(x, y + i);
    add(x + beam.width - 1, y + i);
  }
  // Samples reach half a pixel beyond the centres; two pixels leave room for how the lens stretches
  // them.
  beam.cone = BoundingCone(border, static_cast<float>(2.0 / camera_->FocalLength()));
  return beam;
}

void Renderer::MakeBeams() {
  constexpr int kSide = kTile * kBlock;
  for (int y = 0; y < camera_->height(); y += kSide) {
    for (int x = 0; x < camera_->width(); x += kSide) {
      const Beam& block = blocks_.emplace_back(MakeBeam(x, y, kSide));
      std::vector<Beam>& tiles = tiles_.emplace_back();
      for (int ty = y; ty < y + block.height; ty += kTile) {
        for (int tx = x; tx < x + block.width; tx += kTile) {
          tiles.push_back(MakeBeam(tx, ty, kTile));
        }
      }
    }
  }
}

/// Calls row(packet, x, y, count) for every run of up to 16 pixels, on all threads, block by block.
template <typename Row>
void Renderer::ForEachPacket(const BeamCaster& caster, const RayTable& rays, const Row& row) const {
  static_assert(kTile == RayPacket::kSize, "a packet is one row of a tile");
  ParallelFor(threads_, blocks_.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<std::int32_t> in_block;
    std::vector<std::int32_t> in_tile;
    RayPacket packet;
    for (std::size_t b = begin; b < end; ++b) {
      caster.Cull(blocks_[b].cone, caster.visible(), &in_block);
      for (const Beam& tile : tiles_[b]) {
        caster.Cull(tile.cone, in_block, &in_tile);
        for (int y = tile.y; y < tile.y + tile.height; ++y) {
          const auto first = static_cast<std::ptrdiff_t>(y) * camera_->width() + tile.x;
          std::copy_n(rays.x.begin() + first, tile.width, packet.x.begin());
          std::copy_n(rays.y.begin() + first, tile.width, packet.y.begin());
          std::copy_n(rays.z.begin() + first, tile.width, packet.z.begin());
          caster.Trace(in_tile, &packet);
          row(packet, tile.x, y, tile.width);
        }
      }
    }
  });
}

float Renderer::Shade(const BeamCaster& caster, const RayPacket& packet, int lane) const {
  const std::int32_t index = packet.surface[lane];
  if (index < 0) {
    return 0.0F;
  }
  const Scene& scene = world_->scene();
  const Surface& surface = scene.surfaces[static_cast<std::size_t>(index)];
  if (surface.emission > 0) {
    return surface.emission;
  }
  const Eigen::Vector3f direction(packet.x[lane], packet.y[lane], packet.z[lane]);
  const float range = packet.range[lane];
  const float u = surface.shape == Shape::kCylinder
                      ? caster.AngleCoordinate(index, direction, range)
                      : packet.u[lane];
  const float v = packet.v[lane];
  // A pixel's cone covers an ellipse that slant lengthens; between its axes lies what neither
  // flickers nor blurs.
  const float cosine = std::max(0.05F, caster.CosineOfIncidence(index, direction, u));
  const float footprint = range * pixel_angle_ / std::sqrt(cosine);
  const float period = std::min(surface.period.x(), surface.period.y());
  const float reflectance = scene.textures[static_cast<std::size_t>(surface.texture)].Sample(
      surface.texture_origin.x() + u / surface.period.x(),
      surface.texture_origin.y() + v / surface.period.y(),
      footprint / period);
  return reflectance * SampleLight(scene, surface, u, v);
}

cv::Mat Renderer::RenderRadiance(const Rigid3& T_W_C) const {
  return RenderRadiance(std::vector<Rigid3>(static_cast<std::size_t>(samples_), T_W_C));
}

cv::Mat Renderer::RenderRadiance(const std::vector<Rigid3>& T_W_C) const {
  DEJA_VIEW_CHECK_OP(T_W_C.size(), ==, sample_rays_.size());
  cv::Mat radiance = cv::Mat::zeros(camera_->height(), camera_->width(), CV_32FC1);
  for (std::size_t s = 0; s < T_W_C.size(); ++s) {
    const BeamCaster caster(world_->scene(), T_W_C[s]);
    ForEachPacket(caster, sample_rays_[s], [&](const RayPacket& packet, int x, int y, int count) {
      float* out = radiance.ptr<float>(y) + x;
      for (int i = 0; i < count; ++i) {
        out[i] += Shade(caster, packet, i);
      }
    });
  }
  radiance = radiance * (1.0 / samples_);
  return radiance;
}

cv::Mat Renderer::RenderRange(const Rigid3& T_W_C) const {
  cv::Mat range(camera_->height(), camera_->width(), CV_32FC1);
  const BeamCaster caster(world_->scene(), T_W_C);
  ForEachPacket(caster, centre_rays_, [&](const RayPacket& packet, int x, int y, int count) {
    std::copy_n(packet.range.begin(), count, range.ptr<float>(y) + x);
  });
  return range;
}

View RenderView(const Renderer& renderer, const Rigid3& T_W_C, double gain, double gamma) {
  const cv::Mat radiance = renderer.RenderRadiance(T_W_C);
  View view;
  view.range = renderer.RenderRange(T_W_C);
  view.image.create(radiance.size(), CV_8UC1);
  for (int y = 0; y < radiance.rows; ++y) {
    for (int x = 0; x < radiance.cols; ++x) {
      const double level = std::min(1.0, gain * static_cast<double>(radiance.at<float>(y, x)));
      view.image.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(255.0 * std::pow(level, 1.0 / gamma));
    }
  }
  return view;
}

}  // namespace deja_view::sim
