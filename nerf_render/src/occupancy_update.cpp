#include "occupancy_update.hpp"

#include "deja_view/base/parallel.hpp"

#include <algorithm>

#include "random.hpp"

namespace deja_view::nerf::internal {
namespace {

constexpr float kDecay = 0.9F;
constexpr float kOpticalDepth = 0.01F;  ///< per step, that makes a cell matter

bool Sees(const TrainingView& view, const Eigen::Vector3d& p_N, double radius) {
  const Eigen::Vector3d p_C = view.T_N_C.Inverse() * p_N;
  if (p_C.norm() < 2 * radius) {
    return true;
  }
  const auto pixel = view.camera->Project(p_C);
  const double border = radius / p_C.norm() * view.camera->FocalLength();
  return pixel && view.camera->IsInImage(*pixel, -border);
}

}  // namespace

OccupancyUpdate::OccupancyUpdate(const std::vector<TrainingView>& views,
                                 int threads,
                                 RadianceField* field)
    : density_(field->occupancy.cell_count(), 0.0F), seen_(field->occupancy.words().size(), 0) {
  OccupancyGrid& grid = field->occupancy;
  const double cell = field->box.Size() / static_cast<double>(grid.scale());
  ParallelFor(
      threads,
      seen_.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t block = begin; block < end; ++block) {
          const std::array<int, 3> low = grid.Cell(block * 64);
          const Eigen::Vector3d p_N =
              field->box.min + cell * Eigen::Vector3d(low[0] + 2.0, low[1] + 2.0, low[2] + 2.0);
          // In strides, since neighbouring views see much the same.
          constexpr std::size_t kStride = 37;
          for (std::size_t first = 0; first < kStride && seen_[block] == 0; ++first) {
            for (std::size_t v = first; v < views.size() && seen_[block] == 0; v += kStride) {
              seen_[block] = Sees(views[v], p_N, 3.5 * cell) ? 1 : 0;
            }
          }
          grid.words()[block] = seen_[block] != 0 ? ~std::uint64_t{0} : 0;
        }
      },
      256);
}

void OccupancyUpdate::Run(const Kernels& kernels,
                          const TrainOptions& options,
                          std::uint64_t round,
                          bool full,
                          RadianceField* field) {
  OccupancyGrid& grid = field->occupancy;
  const Eigen::Vector3f extent = field->Extent();
  const float cell = 1 / grid.scale();
  // Not above the mean, so that what has hardly begun to grow is kept.
  double sum = 0;
  std::size_t seen = 0;
  for (std::size_t block = 0; block < seen_.size(); ++block) {
    if (seen_[block] != 0) {
      seen += 64;
      for (std::size_t i = 64 * block; i < 64 * block + 64; ++i) {
        sum += static_cast<double>(density_[i]);
      }
    }
  }
  const float threshold =
      std::min(kOpticalDepth / options.march.min_step,
               static_cast<float>(sum / static_cast<double>(std::max<std::size_t>(1, seen))));
  const auto stride = static_cast<std::size_t>(field->density.row_stride());
  const auto out_stride = static_cast<std::size_t>(field->density.output_stride());
  ParallelFor(
      options.threads,
      seen_.size(),
      [&](std::size_t begin, std::size_t end) {
        std::vector<std::size_t> cells;
        std::vector<float> x, y, z, rows, raw, dt, sigma, unused;
        Network::Activations activations;
        constexpr std::size_t kBlocks = 16;
        for (std::size_t first = begin; first < end; first += kBlocks) {
          cells.clear();
          x.clear();
          y.clear();
          z.clear();
          for (std::size_t block = first; block < std::min(end, first + kBlocks); ++block) {
            if (seen_[block] == 0) {
              continue;
            }
            Random random(options.seed, (round << 32U) + block);
            for (std::size_t i = 64 * block; i < 64 * block + 64; ++i) {
              const bool look = (random.Next() >> 60U) == 0 || grid.IsOccupied(i) || full;
              const std::array<int, 3> at = grid.Cell(i);
              const float u = random.Uniform();
              const float v = random.Uniform();
              const float w = random.Uniform();
              if (look) {
                cells.push_back(i);
                x.push_back(std::min(extent.x(), (static_cast<float>(at[0]) + u) * cell));
                y.push_back(std::min(extent.y(), (static_cast<float>(at[1]) + v) * cell));
                z.push_back(std::min(extent.z(), (static_cast<float>(at[2]) + w) * cell));
              }
            }
          }
          const std::size_t count = cells.size();
          rows.resize(count * stride);
          raw.resize(count);
          dt.assign(count, 0.0F);
          sigma.resize(count);
          unused.resize(count);
          field->geometry.Forward(
              kernels, {x.data(), y.data(), z.data()}, count, stride, rows.data());
          const float* out = field->density.Forward(kernels, rows.data(), count, &activations);
          for (std::size_t i = 0; i < count; ++i) {
            raw[i] = out[i * out_stride];
          }
          kernels.density(raw.data(), dt.data(), count, sigma.data(), unused.data());
          for (std::size_t i = 0; i < count; ++i) {
            float& density = density_[cells[i]];
            density = std::max(kDecay * density, sigma[i]);
            grid.Set(cells[i], density > threshold);
          }
        }
      },
      256);
}

}  // namespace deja_view::nerf::internal
