#pragma once

#include <cstddef>
#include <cstdint>

namespace deja_view::nerf {

/// One level of a feature grid. Entries lie in bricks of 2x2x2, so that the eight corners of a cell
/// are found in 3.4 places on average instead of eight:
///   entry (i, j, k) = 8 brick(i/2, j/2, k/2) + i%2 + 2 (j%2) + 4 (k%2)
///   dense   brick(a, b, c) = a + b stride_y + c stride_z
///   hashed  brick(a, b, c) = (a ^ b 2654435761 ^ c 805459861) & mask   (Müller et al., eq. 4)
struct GridLevel {
  float scale = 1;  ///< cells per unit length
  std::uint32_t stride_y = 0;
  std::uint32_t stride_z = 0;
  std::uint32_t mask = 0;
  bool hashed = false;
  int features = 2;          ///< 2 or 4
  std::uint32_t bricks = 0;  ///< of this level
  std::size_t offset = 0;    ///< of its first value in the grid's parameters
};

/// Positions of samples in unit coordinates, one array per axis.
struct Positions {
  const float* x = nullptr;
  const float* y = nullptr;
  const float* z = nullptr;
};

/// One fully connected layer, y = x W + b. Both sizes are multiples of 16.
struct LayerShape {
  int inputs = 16;
  int outputs = 16;
};

/// Adam without bias correction, for parameters that are seldom touched (Kingma & Ba, ICLR 2015).
struct AdamStep {
  float learning_rate = 1e-2F;
  float beta1 = 0.9F;
  float beta2 = 0.99F;
  float epsilon = 1e-15F;
  float decay = 0;  ///< of a parameter, per learning rate (Loshchilov and Hutter, ICLR 2019)
};

/// The inner loops, in one flavour of instructions. All matrices are row-major; rows of samples are
/// `stride` floats apart. Results may differ between flavours by rounding.
struct Kernels {
  const char* name;

  /// out[s * stride + f] = feature f of sample s, interpolated linearly between eight corners.
  void (*grid_forward)(const GridLevel& level,
                       const float* table,
                       const Positions& p,
                       std::size_t count,
                       float* out,
                       std::size_t stride);

  /// gradient += d out / d table * d_out (count x features), and touched[brick] = 1.
  void (*grid_backward)(const GridLevel& level,
                        const Positions& p,
                        std::size_t count,
                        const float* d_out,
                        float* gradient,
                        std::uint8_t* touched);

  /// y (count x outputs) = x (count x inputs) W (inputs x outputs) + b, then max(0, y) if `relu`.
  /// `bias` may be null.
  void (*layer_forward)(const LayerShape& shape,
                        const float* weights,
                        const float* bias,
                        const float* x,
                        std::size_t count,
                        bool relu,
                        float* y);

  /// d_weights += x^T d_y, d_bias += column sums of d_y.
  void (*layer_gradient)(const LayerShape& shape,
                         const float* x,
                         const float* d_y,
                         std::size_t count,
                         float* d_weights,
                         float* d_bias);

  /// One Adam step on `count` values (a multiple of 16); sets the gradient to 0.
  void (*adam)(const AdamStep& step,
               std::size_t count,
               float* parameters,
               float* gradient,
               float* first,
               float* second);

  /// sigma = exp(raw), transparency = exp(-sigma dt); raw is cut to [-15, 15].
  void (*density)(
      const float* raw, const float* dt, std::size_t count, float* sigma, float* transparency);

  /// y = 1 / (1 + exp(-x)).
  void (*sigmoid)(const float* x, std::size_t count, float* y);
};

}  // namespace deja_view::nerf
