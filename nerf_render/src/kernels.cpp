#include "deja_view/nerf/kernels.hpp"

#include "deja_view/base/check.hpp"

#include "simd_kernels.hpp"

namespace deja_view::nerf {

std::vector<const Kernels*> AvailableKernels() {
  std::vector<const Kernels*> kernels = internal::SimdKernels();
  kernels.push_back(&PortableKernels());
  return kernels;
}

const Kernels& FindKernels(std::string_view name) {
  const std::vector<const Kernels*> available = AvailableKernels();
  if (name == "auto") {
    return *available.front();
  }
  std::string names = "auto";
  for (const Kernels* kernels : available) {
    if (name == kernels->name) {
      return *kernels;
    }
    names += std::string(", ") + kernels->name;
  }
  ThrowInputError("kernels '{}': this machine has {}", name, names);
}

}  // namespace deja_view::nerf
