#include "occupancy_update.hpp"

#include "deja_view/base/parallel.hpp"
#include "deja_view/base/random.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "occupancy_rule.hpp"

namespace deja_view::nerf::internal {
namespace {

constexpr double kCarvedShare = 0.96;  ///< of the way to a depth point is surely empty

bool Sees(const TrainingView& view, const Eigen::Vector3d& p_N, double radius) {
  const Eigen::Vector3d p_C = view.T_N_C.Inverse() * p_N;
  if (p_C.norm() < 2 * radius) {
    return true;
  }
  const auto pixel = view.camera->Project(p_C);
  const double border = radius / p_C.norm() * view.camera->FocalLength();
  return pixel && view.camera->IsInImage(*pixel, -border);
}

/// A random place in each of some cells, and the field's density there.
class CellSamples {
 public:
  void Clear() {
    cells_.clear();
    x_.clear();
    y_.clear();
    z_.clear();
  }

  /// Of the block's cells in `open` those that are due: the occupied ones and one in sixteen of the
  /// others, or all if `full`. Draws the same numbers whichever are.
  void AddBlock(const RadianceField& field,
                std::size_t block,
                std::uint64_t open,
                bool full,
                Random* random) {
    const OccupancyGrid& grid = field.occupancy;
    const Eigen::Vector3f extent = field.Extent();
    const float cell = 1 / grid.scale();
    for (std::size_t i = 64 * block; i < 64 * block + 64; ++i) {
      const bool is_due = (random->Next() >> 60U) == 0 || grid.IsOccupied(i) || full;
      const std::array<int, 3> at = grid.Cell(i);
      const float u = random->UniformFloat();
      const float v = random->UniformFloat();
      const float w = random->UniformFloat();
      if (is_due && (open >> (i % 64) & 1U) != 0) {
        cells_.push_back(i);
        x_.push_back(std::min(extent.x(), (static_cast<float>(at[0]) + u) * cell));
        y_.push_back(std::min(extent.y(), (static_cast<float>(at[1]) + v) * cell));
        z_.push_back(std::min(extent.z(), (static_cast<float>(at[2]) + w) * cell));
      }
    }
  }

  const std::vector<std::size_t>& cells() const { return cells_; }

  /// One per cell [1/unit length]; until the next call.
  const std::vector<float>& Densities(const RadianceField& field, const Kernels& kernels) {
    const std::size_t count = cells_.size();
    const auto stride = static_cast<std::size_t>(field.density.row_stride());
    const auto out_stride = static_cast<std::size_t>(field.density.output_stride());
    rows_.resize(count * stride);
    raw_.resize(count);
    dt_.assign(count, 0.0F);
    sigma_.resize(count);
    unused_.resize(count);
    field.geometry.Forward(kernels, {x_.data(), y_.data(), z_.data()}, count, stride, rows_.data());
    const float* out = field.density.Forward(kernels, rows_.data(), count, &activations_);
    for (std::size_t i = 0; i < count; ++i) {
      raw_[i] = out[i * out_stride];
    }
    kernels.density(raw_.data(), dt_.data(), count, sigma_.data(), unused_.data());
    return sigma_;
  }

 private:
  std::vector<std::size_t> cells_;
  std::vector<float> x_, y_, z_, rows_, raw_, dt_, sigma_, unused_;
  Network::Activations activations_;
};

}  // namespace

OccupancyUpdate::OccupancyUpdate(const std::vector<TrainingView>& views,
                                 int threads,
                                 int carve_votes,
                                 RadianceField* field)
    : density_(field->occupancy.cell_count(), 0.0F), open_(field->occupancy.words().size(), 0) {
  FindSeen(views, threads, *field);
  if (carve_votes > 0) {
    Carve(views, carve_votes, *field);
  }
  field->occupancy.SetWords(open_);
}

OccupancyUpdate::OccupancyUpdate(std::vector<std::uint64_t> open)
    : density_(64 * open.size(), 0.0F), open_(std::move(open)) {}

void OccupancyUpdate::FindSeen(const std::vector<TrainingView>& views,
                               int threads,
                               const RadianceField& field) {
  const OccupancyGrid& grid = field.occupancy;
  const double cell = field.box.Size() / static_cast<double>(grid.scale());
  ParallelFor(
      threads,
      open_.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t block = begin; block < end; ++block) {
          const std::array<int, 3> low = grid.Cell(block * 64);
          const Eigen::Vector3d p_N =
              field.box.min + cell * Eigen::Vector3d(low[0] + 2.0, low[1] + 2.0, low[2] + 2.0);
          // In strides, since neighbouring views see much the same.
          constexpr std::size_t kStride = 37;
          bool seen = false;
          for (std::size_t first = 0; first < kStride && !seen; ++first) {
            for (std::size_t v = first; v < views.size() && !seen; v += kStride) {
              seen = Sees(views[v], p_N, 3.5 * cell);
            }
          }
          open_[block] = seen ? ~std::uint64_t{0} : 0;
        }
      },
      256);
}

void OccupancyUpdate::Carve(const std::vector<TrainingView>& views,
                            int votes,
                            const RadianceField& field) {
  const OccupancyGrid& grid = field.occupancy;
  const double cell = field.box.Size() / static_cast<double>(grid.scale());
  const auto cell_of = [&](const Eigen::Vector3d& p_N) -> Eigen::Array3i {
    return ((p_N - field.box.min) / cell).array().floor().cast<int>();
  };
  const auto is_inside = [&](const Eigen::Array3i& at) {
    return (at >= 0).all() && at.x() < grid.cells()[0] && at.y() < grid.cells()[1] &&
           at.z() < grid.cells()[2];
  };
  std::vector<std::uint8_t> passed(grid.cell_count(), 0);
  std::vector<std::uint8_t> beside(grid.cell_count(), 0);
  for (const TrainingView& view : views) {
    for (const DepthPoint& point : view.points) {
      const Eigen::Vector3d ray_N = view.T_N_C.q * view.camera->Unproject({point.u, point.v});
      const auto range = static_cast<double>(point.range);
      std::size_t last = grid.cell_count();
      for (double t = 0; t < kCarvedShare * range - cell; t += cell / 2) {
        const Eigen::Array3i at = cell_of(view.T_N_C.t + t * ray_N);
        if (!is_inside(at)) {
          continue;
        }
        const std::size_t index = grid.Index(at.x(), at.y(), at.z());
        if (index != last && passed[index] < 255) {
          ++passed[index];
        }
        last = index;
      }
      const Eigen::Array3i center = cell_of(view.T_N_C.t + range * ray_N);
      for (int i = 0; i < 27; ++i) {
        const Eigen::Array3i at = center + Eigen::Array3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
        if (is_inside(at)) {
          beside[grid.Index(at.x(), at.y(), at.z())] = 1;
        }
      }
    }
  }
  for (std::size_t i = 0; i < passed.size(); ++i) {
    if (passed[i] >= votes && beside[i] == 0) {
      open_[i / 64] &= ~(std::uint64_t{1} << (i % 64));
    }
  }
}

float OccupancyUpdate::Threshold(const TrainOptions& options) const {
  // Not near the mean, so that what has hardly begun to grow is kept.
  double sum = 0;
  std::size_t open = 0;
  for (std::size_t i = 0; i < density_.size(); ++i) {
    if ((open_[i / 64] >> (i % 64) & 1U) != 0) {
      ++open;
      sum += static_cast<double>(density_[i]);
    }
  }
  return std::min(options.occupancy_threshold / options.march.min_step,
                  static_cast<float>(kOccupancyShareOfMean * sum /
                                     static_cast<double>(std::max<std::size_t>(1, open))));
}

void OccupancyUpdate::Run(const Kernels& kernels,
                          const TrainOptions& options,
                          std::uint64_t round,
                          bool full,
                          RadianceField* field) {
  OccupancyGrid& grid = field->occupancy;
  const float threshold = Threshold(options);
  ParallelFor(
      options.threads,
      open_.size(),
      [&](std::size_t begin, std::size_t end) {
        CellSamples samples;
        constexpr std::size_t kBlocks = 16;
        for (std::size_t first = begin; first < end; first += kBlocks) {
          samples.Clear();
          for (std::size_t block = first; block < std::min(end, first + kBlocks); ++block) {
            if (open_[block] != 0) {
              Random random(options.seed, (round << 32U) + block);
              samples.AddBlock(*field, block, open_[block], full, &random);
            }
          }
          const std::vector<float>& sigma = samples.Densities(*field, kernels);
          for (std::size_t i = 0; i < sigma.size(); ++i) {
            const std::size_t cell = samples.cells()[i];
            density_[cell] = std::max(kOccupancyDecay * density_[cell], sigma[i]);
            grid.Set(cell, density_[cell] > threshold);
          }
        }
      },
      256);
  grid.FindLeaps();
}

}  // namespace deja_view::nerf::internal
