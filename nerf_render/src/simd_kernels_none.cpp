#include "simd_kernels.hpp"

namespace deja_view::nerf::internal {

std::vector<const Kernels*> SimdKernels() {
  return {};
}

}  // namespace deja_view::nerf::internal
