#include "deja_view/lab/sim/renderer.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"

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
  const double sample_angle = 1.0 / (camera_->FocalLength() * std::sqrt(samples));
  shader_ = std::make_unique<Shader>(world_->scene(), static_cast<float>(sample_angle));
  MakeBlocks();
  centre_rays_ = MakeRays(Eigen::Vector2d::Zero());
  for (int i = 0; i < samples; ++i) {
    sample_rays_.push_back(samples == 1 ? centre_rays_ : MakeRays(SampleOffset(i)));
  }
}

Renderer::Beam Renderer::MakeBeam(int x, int y, int size) const {
  Beam beam{x, y, std::min(size, camera_->width() - x), std::min(size, camera_->height() - y), {}};
  std::vector<Eigen::Vector3f> border;
  const auto add = [&](int px, int py) {
    border.emplace_back(camera_->Unproject({px, py}).cast<float>());
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

void Renderer::MakeBlocks() {
  constexpr int kSide = kTile * kBlock;
  for (int y = 0; y < camera_->height(); y += kSide) {
    for (int x = 0; x < camera_->width(); x += kSide) {
      Block& block = blocks_.emplace_back();
      block.beam = MakeBeam(x, y, kSide);
      for (int ty = y; ty < y + block.beam.height; ty += kTile) {
        for (int tx = x; tx < x + block.beam.width; tx += kTile) {
          block.tiles.push_back({MakeBeam(tx, ty, kTile), row_count_});
          row_count_ += static_cast<std::size_t>(block.tiles.back().beam.height);
        }
      }
    }
  }
}

Renderer::RayTable Renderer::MakeRays(const Eigen::Vector2d& offset) const {
  RayTable rays(row_count_);
  ParallelFor(threads_, blocks_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      for (const Tile& tile : blocks_[b].tiles) {
        for (int y = 0; y < tile.beam.height; ++y) {
          RayRow& row = rays[tile.first_row + static_cast<std::size_t>(y)];
          for (int i = 0; i < kTile; ++i) {
            // Lanes beyond the image repeat its last pixel.
            const int x = tile.beam.x + std::min(i, tile.beam.width - 1);
            const Eigen::Vector2d pixel = Eigen::Vector2d(x, tile.beam.y + y) + offset;
            const Eigen::Vector3f ray = camera_->Unproject(pixel).cast<float>();
            row.x[i] = ray.x();
            row.y[i] = ray.y();
            row.z[i] = ray.z();
          }
        }
      }
    }
  });
  return rays;
}

/// Calls row(packet, x, y, count) for every run of up to 16 pixels of a block.
template <typename Row>
void Renderer::TraceBlock(const BeamCaster& caster,
                          const Block& block,
                          const RayTable& rays,
                          const Row& row) const {
  static_assert(kTile == RayPacket::kSize, "a packet is one row of a tile");
  std::vector<std::int32_t> in_block;
  std::vector<std::int32_t> in_tile;
  RayPacket packet;
  caster.Cull(block.beam.cone, caster.visible(), &in_block);
  for (const Tile& tile : block.tiles) {
    caster.Cull(tile.beam.cone, in_block, &in_tile);
    for (int y = 0; y < tile.beam.height; ++y) {
      const RayRow& ray_row = rays[tile.first_row + static_cast<std::size_t>(y)];
      packet.x = ray_row.x;
      packet.y = ray_row.y;
      packet.z = ray_row.z;
      caster.Trace(in_tile, &packet);
      row(packet, tile.beam.x, tile.beam.y + y, tile.beam.width);
    }
  }
}

cv::Mat Renderer::RenderRadiance(const Rigid3& T_W_C) const {
  return RenderRadiance(std::vector<Rigid3>(static_cast<std::size_t>(samples_), T_W_C));
}

cv::Mat Renderer::RenderRadiance(const std::vector<Rigid3>& T_W_C) const {
  DEJA_VIEW_CHECK_OP(T_W_C.size(), ==, sample_rays_.size());
  std::vector<BeamCaster> casters;
  for (const Rigid3& pose : T_W_C) {
    casters.emplace_back(world_->scene(), pose);
  }
  cv::Mat radiance = cv::Mat::zeros(camera_->height(), camera_->width(), CV_32FC1);
  const float share = 1.0F / static_cast<float>(samples_);
  ParallelFor(threads_, blocks_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      for (std::size_t s = 0; s < casters.size(); ++s) {
        const auto add = [&](RayPacket& packet, int x, int y, int count) {
          casters[s].Complete(&packet);
          const Shader::Lanes shaded = shader_->Shade(packet);
          float* out = radiance.ptr<float>(y) + x;
          for (int i = 0; i < count; ++i) {
            out[i] += share * shaded[i];
          }
        };
        TraceBlock(casters[s], blocks_[b], sample_rays_[s], add);
      }
    }
  });
  return radiance;
}

cv::Mat Renderer::RenderRange(const Rigid3& T_W_C) const {
  cv::Mat range(camera_->height(), camera_->width(), CV_32FC1);
  const BeamCaster caster(world_->scene(), T_W_C);
  ParallelFor(threads_, blocks_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      const auto copy = [&](const RayPacket& packet, int x, int y, int count) {
        std::copy_n(packet.range.begin(), count, range.ptr<float>(y) + x);
      };
      TraceBlock(caster, blocks_[b], centre_rays_, copy);
    }
  });
  return range;
}

cv::Mat ToneMap(const cv::Mat& radiance, double gain, double gamma) {
  cv::Mat image(radiance.size(), CV_8UC1);
  for (int y = 0; y < radiance.rows; ++y) {
    for (int x = 0; x < radiance.cols; ++x) {
      const double level = std::min(1.0, gain * static_cast<double>(radiance.at<float>(y, x)));
      image.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(255.0 * std::pow(level, 1.0 / gamma));
    }
  }
  return image;
}

View RenderView(const Renderer& renderer, const Rigid3& T_W_C, double gain, double gamma) {
  return {ToneMap(renderer.RenderRadiance(T_W_C), gain, gamma), renderer.RenderRange(T_W_C)};
}

}  // namespace deja_view::sim
