#pragma once

#include "deja_view/nerf/kernel_table.hpp"

#include <vector>

namespace deja_view::nerf::internal {

/// The Highway kernels that this CPU can run, widest first; none in a build without Highway.
std::vector<const Kernels*> SimdKernels();

}  // namespace deja_view::nerf::internal
