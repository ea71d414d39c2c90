#include "deja_view/nerf/network.hpp"

#include "deja_view/base/random.hpp"

#include <cmath>

namespace deja_view::nerf {
namespace {

int Padded(int size) {
  return (size + 15) / 16 * 16;
}

}  // namespace

Network::Network(const std::vector<int>& sizes, std::uint64_t seed) {
  Random random(seed, 1);
  for (std::size_t l = 0; l + 1 < sizes.size(); ++l) {
    const LayerShape shape{Padded(sizes[l]), Padded(sizes[l + 1])};
    const auto stride = static_cast<std::size_t>(shape.outputs);
    Offsets offsets;
    offsets.weights = parameters_.size();
    offsets.bias = offsets.weights + static_cast<std::size_t>(shape.inputs) * stride;
    parameters_.resize(offsets.bias + stride, 0.0F);
    const float range = std::sqrt(6.0F / static_cast<float>(sizes[l] + sizes[l + 1]));
    for (int i = 0; i < sizes[l]; ++i) {
      for (int o = 0; o < sizes[l + 1]; ++o) {
        parameters_[offsets.weights + static_cast<std::size_t>(i) * stride +
                    static_cast<std::size_t>(o)] = (2 * random.UniformFloat() - 1) * range;
      }
    }
    layers_.push_back(shape);
    offsets_.push_back(offsets);
  }
  UpdateTranspose();
}

void Network::UpdateTranspose() {
  transposed_.resize(parameters_.size());
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const auto inputs = static_cast<std::size_t>(layers_[l].inputs);
    const auto outputs = static_cast<std::size_t>(layers_[l].outputs);
    for (std::size_t i = 0; i < inputs; ++i) {
      for (std::size_t o = 0; o < outputs; ++o) {
        transposed_[offsets_[l].weights + o * inputs + i] =
            parameters_[offsets_[l].weights + i * outputs + o];
      }
    }
  }
}

const float* Network::Forward(const Kernels& kernels,
                              const float* x,
                              std::size_t count,
                              Activations* activations) const {
  activations->outputs.resize(layers_.size());
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    std::vector<float>& y = activations->outputs[l];
    y.resize(count * static_cast<std::size_t>(layers_[l].outputs));
    kernels.layer_forward(layers_[l],
                          parameters_.data() + offsets_[l].weights,
                          parameters_.data() + offsets_[l].bias,
                          x,
                          count,
                          l + 1 < layers_.size(),
                          y.data());
    x = y.data();
  }
  return x;
}

void Network::Backward(const Kernels& kernels,
                       const float* x,
                       const float* d_out,
                       std::size_t count,
                       Activations* activations,
                       float* d_parameters,
                       float* d_x) const {
  const float* d_y = d_out;
  for (std::size_t l = layers_.size(); l-- > 0;) {
    const float* in = l > 0 ? activations->outputs[l - 1].data() : x;
    kernels.layer_gradient(layers_[l],
                           in,
                           d_y,
                           count,
                           d_parameters + offsets_[l].weights,
                           d_parameters + offsets_[l].bias);
    if (l == 0 && d_x == nullptr) {
      return;
    }
    const LayerShape back{layers_[l].outputs, layers_[l].inputs};
    const std::size_t size = count * static_cast<std::size_t>(back.outputs);
    activations->next_gradient.resize(size);
    float* d_in = l == 0 ? d_x : activations->next_gradient.data();
    kernels.layer_forward(
        back, transposed_.data() + offsets_[l].weights, nullptr, d_y, count, false, d_in);
    if (l > 0) {
      for (std::size_t i = 0; i < size; ++i) {
        d_in[i] = in[i] > 0 ? d_in[i] : 0.0F;  // ReLU
      }
      activations->gradient.swap(activations->next_gradient);
      d_y = activations->gradient.data();
    }
  }
}

}  // namespace deja_view::nerf
