#pragma once

#include <algorithm>
#include <vector>

#include "device_field.cuh"
#include "occupancy_rule.hpp"

namespace deja_view::nerf::internal {

/// OccupancyUpdate on a device.
template <typename System>
class DeviceOccupancy {
 public:
  /// `open` as OccupancyUpdate::open.
  DeviceOccupancy(const TrainOptions& options, const std::vector<std::uint64_t>& open)
      : options_(options) {
    open_.Upload(open);
    density_.ResizeToZeros(64 * open.size());
    for (std::uint64_t word : open) {
      for (; word != 0; word &= word - 1) {
        ++open_cells_;
      }
    }
  }

  void Run(std::uint64_t round, bool full, DeviceField<System>* field) {
    const float threshold = Threshold();
    const CellRule rule{field->occupancy(), open_.data(), options_.seed, round, full};
    const std::size_t blocks = open_.size();
    constexpr std::size_t kFew = 16;
    constexpr std::size_t kMost = 96;
    const DensityView density = field->density_view();
    if (field->density.inputs() == kFew) {
      ForEach<System>(64 * blocks,
                      LookIntoCell<kFew>{rule, density, field->extent(), density_.data()});
    } else {
      ForEach<System>(64 * blocks,
                      LookIntoCell<kMost>{rule, density, field->extent(), density_.data()});
    }
    ForEach<System>(blocks, MarkBlock{rule, density_.data(), threshold, field->words.data()});
    field->FindLeaps();
  }

 private:
  // In a fixed order, hence the same every time.
  float Threshold() {
    block_sums_.Resize(open_.size());
    ForEach<System>(open_.size(), SumBlock{open_.data(), density_.data(), block_sums_.data()});
    double sum = 0;
    for (const double of_block : block_sums_.Download()) {
      sum += of_block;
    }
    const auto cells = static_cast<double>(std::max<std::size_t>(1, open_cells_));
    return std::min(options_.occupancy_threshold / options_.march.min_step,
                    static_cast<float>(kOccupancyShareOfMean * sum / cells));
  }

  TrainOptions options_;
  std::size_t open_cells_ = 0;
  DeviceArray<System, std::uint64_t> open_;
  DeviceArray<System, float> density_;
  DeviceArray<System, double> block_sums_;
};

}  // namespace deja_view::nerf::internal
