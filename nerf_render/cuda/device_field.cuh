#pragma once

#include <memory>
#include <vector>

#include "device_engine.hpp"
#include "device_memory.cuh"
#include "field_views.cuh"
#include "launch.cuh"
#include "layers.cuh"
#include "occupancy.cuh"

namespace deja_view::nerf::internal {

/// A field's numbers on a device.
template <typename System>
struct DeviceGrid {
  void Load(const FieldLayout::Grid& layout, const float* from) {
    levels.Upload(layout.levels);
    values.Upload(from, layout.values);
    features = layout.levels.empty() ? 0 : static_cast<std::size_t>(layout.levels[0].features);
  }
  GridView view() const { return {levels.data(), levels.size(), features, values.data()}; }
  std::size_t outputs() const { return levels.size() * features; }
  std::size_t bricks() const { return features == 0 ? 0 : values.size() / (8 * features); }

  DeviceArray<System, GridLevel> levels;
  DeviceArray<System, float> values;
  std::size_t features = 0;
};

/// Working memory of DeviceNetwork::Backward.
template <typename System>
struct BackwardRows {
  DeviceArray<System, float> sums, odd, even;
};

/// A network's numbers on a device, and the rows that its layers write.
template <typename System>
class DeviceNetwork {
 public:
  void Load(const std::vector<LayerShape>& shapes, const float* from) {
    shapes_ = shapes;
    rows_.clear();
    std::size_t size = 0;
    for (const LayerShape& shape : shapes) {
      size += static_cast<std::size_t>((shape.inputs + 1) * shape.outputs);
      rows_.push_back(std::make_unique<DeviceArray<System, float>>());
    }
    values.Upload(from, size);
  }

  /// Gives back what Forward took.
  void Release() {
    for (const auto& rows : rows_) {
      rows->Release();
    }
  }

  std::size_t layers() const { return shapes_.size(); }
  std::size_t inputs() const { return static_cast<std::size_t>(shapes_.front().inputs); }
  std::size_t outputs() const { return static_cast<std::size_t>(shapes_.back().outputs); }

  /// Layer `l`, and where its numbers begin.
  LayerView layer(std::size_t l) const {
    LayerView view;
    view.inputs = static_cast<std::size_t>(shapes_[l].inputs);
    view.outputs = static_cast<std::size_t>(shapes_[l].outputs);
    view.weights = values.data() + offset(l);
    view.bias = view.weights + view.inputs * view.outputs;
    return view;
  }
  std::size_t offset(std::size_t l) const {
    std::size_t offset = 0;
    for (std::size_t i = 0; i < l; ++i) {
      offset += static_cast<std::size_t>((shapes_[i].inputs + 1) * shapes_[i].outputs);
    }
    return offset;
  }

  /// x: samples x inputs(). The result, samples x outputs(), is held until the next call.
  const float* Forward(const float* x, std::size_t samples) { return Run(x, samples, layers()); }
  /// All that Backward needs.
  void ForwardHidden(const float* x, std::size_t samples) { Run(x, samples, layers() - 1); }

  /// Behind Forward or ForwardHidden of the same x: adds to `gradient` (as values) and writes the
  /// derivative of x.
  void Backward(const float* x,
                const float* d_out,
                std::size_t samples,
                BackwardRows<System>* scratch,
                float* gradient,
                float* d_x) {
    const float* d_y = d_out;
    for (std::size_t l = layers(); l-- > 0;) {
      const LayerView view = layer(l);
      const float* in = l > 0 ? rows_[l - 1]->data() : x;
      AddGradient(view, in, d_y, samples, &scratch->sums, gradient + offset(l));
      DeviceArray<System, float>& to = l % 2 == 0 ? scratch->even : scratch->odd;
      if (l > 0) {
        to.Resize(samples * view.inputs);
      }
      float* d_in = l > 0 ? to.data() : d_x;
      ForEach<System>(samples * view.inputs, LayerBackward{view, d_y, l > 0 ? in : nullptr, d_in});
      d_y = d_in;
    }
  }

  DeviceArray<System, float> values;

 private:
  const float* Run(const float* x, std::size_t samples, std::size_t end) {
    for (std::size_t l = 0; l < end; ++l) {
      const LayerView view = layer(l);
      rows_[l]->Resize(samples * view.outputs);
      ForEach<System>(samples * view.outputs,
                      LayerForward{view, x, l + 1 < layers(), rows_[l]->data()});
      x = rows_[l]->data();
    }
    return x;
  }

  void AddGradient(const LayerView& view,
                   const float* x,
                   const float* d_y,
                   std::size_t samples,
                   DeviceArray<System, float>* sums,
                   float* gradient) {
    const std::size_t groups = (samples + kSamplesPerSum - 1) / kSamplesPerSum;
    LayerGradient layer_gradient{view, x, d_y, samples, nullptr};
    const std::size_t width = layer_gradient.width();
    sums->Resize(groups * width);
    layer_gradient.sums = sums->data();
    ForEach<System>(groups * width, layer_gradient);
    ForEach<System>(width, AddGroups{sums->data(), groups, width, gradient});
  }

  std::vector<LayerShape> shapes_;
  std::vector<std::unique_ptr<DeviceArray<System, float>>> rows_;
};

/// A field on a device.
template <typename System>
class DeviceField {
 public:
  void Load(const FieldLayout& new_layout, const DeviceEngine::ConstArrays& from) {
    layout = new_layout;
    geometry.Load(layout.geometry, from.geometry);
    appearance.Load(layout.appearance, from.appearance);
    density.Load(layout.density, from.density);
    color.Load(layout.color, from.color);
    if (has_background()) {
      background.Load(layout.background, from.background);
      background_color.Load(layout.background_color, from.background_color);
    }
    words.Upload(from.occupancy_words, block_count());
    FindLeaps();
  }
  void Save(const DeviceEngine::Arrays& to) const {
    geometry.values.Download(to.geometry);
    appearance.values.Download(to.appearance);
    density.values.Download(to.density);
    color.values.Download(to.color);
    if (has_background()) {
      background.values.Download(to.background);
      background_color.values.Download(to.background_color);
    }
    words.Download(to.occupancy_words);
  }

  /// Gives back what rays took.
  void Release() {
    density.Release();
    color.Release();
    background_color.Release();
  }

  bool has_background() const { return !layout.background.levels.empty(); }
  std::size_t channels() const { return static_cast<std::size_t>(layout.channels); }
  std::size_t latent_size() const { return static_cast<std::size_t>(layout.latent_size); }
  std::size_t block_count() const {
    const std::array<int, 3>& n = layout.occupancy.blocks;
    return static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) *
           static_cast<std::size_t>(n[2]);
  }
  std::array<float, 3> extent() const {
    return {static_cast<float>(layout.box.extent[0]),
            static_cast<float>(layout.box.extent[1]),
            static_cast<float>(layout.box.extent[2])};
  }
  OccupancyView occupancy() const {
    OccupancyView view = layout.occupancy;
    view.words = words.data();
    view.leaps = leaps.data();
    return view;
  }
  DensityView density_view() const { return {geometry.view(), density.layer(0), density.layer(1)}; }

  /// OccupancyGrid::FindLeaps.
  void FindLeaps() {
    const std::size_t blocks = block_count();
    leaps.Resize(blocks);
    next_leaps_.Resize(blocks);
    ForEach<System>(blocks, StartLeaps{words.data(), leaps.data()});
    std::size_t stride = 1;
    for (const int side : layout.occupancy.blocks) {
      const auto count = static_cast<std::size_t>(side);
      ForEach<System>(blocks, SpreadLeaps{count, stride, leaps.data(), next_leaps_.data()});
      ForEach<System>(blocks, SpreadLeaps{1, 1, next_leaps_.data(), leaps.data()});
      stride *= count;
    }
  }

  FieldLayout layout;
  DeviceGrid<System> geometry, appearance, background;
  DeviceNetwork<System> density, color, background_color;
  DeviceArray<System, std::uint64_t> words;
  DeviceArray<System, std::uint8_t> leaps;

 private:
  DeviceArray<System, std::uint8_t> next_leaps_;
};

}  // namespace deja_view::nerf::internal
