#pragma once

#include "deja_view/nerf/kernel_table.hpp"

#include <string_view>
#include <vector>

namespace deja_view::nerf {

/// Plain C++, the reference for the others.
const Kernels& PortableKernels();

/// All that this machine can run, the fastest first, PortableKernels() last.
std::vector<const Kernels*> AvailableKernels();

/// By name; "auto" is the fastest. Throws InputError that lists the names for an unknown one.
const Kernels& FindKernels(std::string_view name);

}  // namespace deja_view::nerf
