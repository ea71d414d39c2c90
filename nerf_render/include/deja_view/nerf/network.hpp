#pragma once

#include "deja_view/nerf/kernel_table.hpp"

#include <cstdint>
#include <vector>

namespace deja_view::nerf {

/// A small fully connected network with ReLU between its layers and none behind the last. Sizes are
/// padded to multiples of 16 with zeros.
class Network {
 public:
  Network() = default;
  /// `sizes`: inputs, hidden layers, outputs; Xavier's uniform initialisation, zero biases.
  Network(const std::vector<int>& sizes, std::uint64_t seed);

  /// What Backward needs of Forward: the output of every layer, count x outputs.
  struct Activations {
    std::vector<std::vector<float>> outputs;
    std::vector<float> gradient;
    std::vector<float> next_gradient;
  };

  const std::vector<LayerShape>& layers() const { return layers_; }
  int row_stride() const { return layers_.front().inputs; }
  int output_stride() const { return layers_.back().outputs; }
  std::vector<float>& parameters() { return parameters_; }
  const std::vector<float>& parameters() const { return parameters_; }
  /// Bias of output `o` of the last layer.
  float& OutputBias(int o) {
    return parameters_[offsets_.back().bias + static_cast<std::size_t>(o)];
  }

  /// x: count x row_stride(). Returns count x output_stride(), held by `activations`.
  const float* Forward(const Kernels& kernels,
                       const float* x,
                       std::size_t count,
                       Activations* activations) const;

  /// From d_out (count x output_stride()): adds to `d_parameters` (as parameters()) and, when d_x
  /// is given, writes the gradient of x.
  void Backward(const Kernels& kernels,
                const float* x,
                const float* d_out,
                std::size_t count,
                Activations* activations,
                float* d_parameters,
                float* d_x) const;

  /// Refreshes the transposed weights that Backward reads; call after changing parameters().
  void UpdateTranspose();

 private:
  struct Offsets {
    std::size_t weights = 0;
    std::size_t bias = 0;
  };
  std::vector<LayerShape> layers_;
  std::vector<Offsets> offsets_;
  std::vector<float> parameters_;
  std::vector<float> transposed_;
};

}  // namespace deja_view::nerf
