#include "ray_batch.hpp"

#include "deja_view/base/parallel.hpp"
#include "deja_view/base/random.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view::nerf::internal {
RayBatch::RayBatch(const TrainOptions& options, const std::vector<TrainingView>& views)
    : options_(options),
      views_(views),
      squares_{options.patch_px, options.textured_share, options.textured_of} {
  for (std::size_t v = 0; v < views.size(); ++v) {
    squares_.side = std::min({squares_.side, views[v].image.cols, views[v].image.rows});
    const Camera& camera = *views[v].camera;
    std::vector<Pixel>& directions = directions_[&camera];
    if (directions.empty()) {
      const auto width = static_cast<std::size_t>(camera.width());
      directions.resize(width * static_cast<std::size_t>(camera.height()));
      ParallelFor(
          options.threads,
          directions.size(),
          [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
              const Eigen::Vector3f d =
                  camera.Unproject({static_cast<double>(i % width), static_cast<double>(i / width)})
                      .cast<float>();
              directions[i] = {d.x(), d.y(), d.z()};
            }
          },
          4096);
    }
    directions_of_.push_back(&directions);
    for (std::size_t p = 0; p < views[v].points.size(); ++p) {
      points_.push_back({static_cast<std::uint32_t>(v), static_cast<std::uint32_t>(p)});
    }
  }
}

void RayBatch::AddRay(const RadianceField& field,
                      const ImageParameters& images,
                      std::uint32_t v,
                      int x,
                      int y,
                      float jitter,
                      std::vector<Ray>* rays,
                      std::vector<RayTarget>* targets) const {
  const TrainingView& view = views_[v];
  const Pixel& d =
      (*directions_of_[v])[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.image.cols) +
                           static_cast<std::size_t>(x)];
  const Eigen::Vector3d direction_C(
      static_cast<double>(d.x), static_cast<double>(d.y), static_cast<double>(d.z));
  const Rigid3& T_N_C = images.T_N_C(v);
  rays->push_back(MakeRay(field, T_N_C.t, T_N_C.q * direction_C, jitter));
  rays->back().latent = images.latent(v);
  RayTarget target;
  target.view = v;
  target.off_axis = 1 - d.z;
  target.vignetting = field.vignetting.At(target.off_axis);
  target.backdrop = BackdropOf(jitter);
  const int channels = view.image.channels();
  const std::uint8_t* pixel = view.image.ptr(y) + static_cast<std::ptrdiff_t>(x) * channels;
  for (int c = 0; c < channels; ++c) {
    target.color[static_cast<std::size_t>(c)] = static_cast<float>(pixel[c]) / 255;
  }
  targets->push_back(target);
}

void RayBatch::Draw(const RadianceField& field,
                    const ImageParameters& images,
                    std::uint64_t step,
                    std::size_t chunk,
                    float depth_share,
                    std::vector<Ray>* rays,
                    std::vector<RayTarget>* targets) const {
  Random random(options_.seed, step * 65536 + chunk);
  rays->clear();
  targets->clear();
  const auto depth_rays =
      points_.empty() || options_.depth_weight == 0
          ? std::size_t{0}
          : static_cast<std::size_t>(depth_share * static_cast<float>(kRaysPerChunk));
  for (std::size_t i = 0; i < depth_rays; ++i) {
    const PointRef ref = points_[random.Index(static_cast<std::uint32_t>(points_.size()))];
    const TrainingView& view = views_[ref.view];
    const DepthPoint& point = view.points[ref.point];
    const int x = std::clamp(static_cast<int>(std::lround(point.u)), 0, view.image.cols - 1);
    const int y = std::clamp(static_cast<int>(std::lround(point.v)), 0, view.image.rows - 1);
    AddRay(field, images, ref.view, x, y, random.UniformFloat(), rays, targets);
    targets->back().range = point.range / static_cast<float>(field.box.Size());
  }
  while (rays->size() < kRaysPerChunk) {
    const std::uint32_t v = random.Index(static_cast<std::uint32_t>(views_.size()));
    const cv::Mat& image = views_[v].image;
    const int side = squares_.side;
    const PixelRows pixels{image.ptr(),
                           image.cols,
                           image.rows,
                           static_cast<std::size_t>(image.channels()),
                           image.step};
    const SquareCorner at = DrawSquare(pixels, squares_, &random);
    for (int i = 0; i < side * side && rays->size() < kRaysPerChunk; ++i) {
      AddRay(
          field, images, v, at.x + i % side, at.y + i / side, random.UniformFloat(), rays, targets);
    }
  }
}

}  // namespace deja_view::nerf::internal
