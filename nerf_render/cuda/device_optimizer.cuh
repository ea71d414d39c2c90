#pragma once

#include "device_field.cuh"
#include "grids.cuh"

namespace deja_view::nerf::internal {

/// Adam's memory of a network on a device.
template <typename System>
class DeviceDenseAdam {
 public:
  void Start(std::size_t size) {
    for (auto* values : {&gradient, &first_, &second_}) {
      values->ResizeToZeros(size);
    }
  }
  AdamArrays Arrays(DeviceArray<System, float>* parameters) {
    return {parameters->data(), gradient.data(), first_.data(), second_.data()};
  }
  void Update(const AdamStep& step, DeviceArray<System, float>* parameters) {
    ForEach<System>(gradient.size(), AdamOfAll{step, Arrays(parameters)});
  }

  DeviceArray<System, float> gradient;

 private:
  DeviceArray<System, float> first_, second_;
};

/// What GridOptimizer does: carries gradients from samples to a grid's entries, and Adam's step on
/// what they touched.
template <typename System>
class DeviceGridOptimizer {
 public:
  void Start(const DeviceGrid<System>& grid, bool deterministic) {
    adam_.Start(grid.values.size());
    touched_.ResizeToZeros(grid.bricks());
    brick_ = 8 * grid.features;
    deterministic_ = deterministic;
  }

  void Add(const DeviceGrid<System>& grid,
           const PlaceArrays& places,
           const float* d_rows,
           std::size_t stride,
           std::size_t samples) {
    const ScatterArrays arrays{
        grid.view(), places, d_rows, stride, adam_.gradient.data(), touched_.data()};
    const std::size_t count = samples * grid.levels.size();
    if (!deterministic_) {
      ForEach<System>(count, ScatterLevel{arrays});
      return;
    }
    entries_.Resize(8 * count);
    items_.Resize(8 * count);
    weights_.Resize(8 * count);
    ForEach<System>(count, ListCorners{arrays, entries_.data(), items_.data(), weights_.data()});
    if (count > 0) {
      SortByKey<System>(entries_.data(), 8 * count, items_.data());
    }
    ForEach<System>(8 * count,
                    SumSorted{arrays, entries_.data(), items_.data(), weights_.data(), 8 * count});
  }

  void Update(const AdamStep& step, DeviceGrid<System>* grid) {
    ForEach<System>(grid->values.size(),
                    AdamOfTouched{step, adam_.Arrays(&grid->values), touched_.data(), brick_});
    touched_.Clear();
  }
  /// Gives back what samples took.
  void Release() {
    entries_.Release();
    items_.Release();
    weights_.Release();
  }
  void DropGradient() {
    adam_.gradient.Clear();
    touched_.Clear();
  }

 private:
  DeviceDenseAdam<System> adam_;
  DeviceArray<System, std::uint8_t> touched_;  ///< per brick
  DeviceArray<System, std::uint32_t> entries_, items_;
  DeviceArray<System, float> weights_;
  std::size_t brick_ = 16;
  bool deterministic_ = false;
};

}  // namespace deja_view::nerf::internal
