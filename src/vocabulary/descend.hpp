#pragma once

#include "deja_view/vocabulary/bow_vector.hpp"

#include <cstddef>
#include <vector>

#include "flat_format.hpp"

namespace deja_view::internal {

/// Writes the words of `count` descriptors to `words`.
using DescendFunction = void (*)(const FlatView& view,
                                 const Descriptor* descriptors,
                                 std::size_t count,
                                 WordId* words);

/// One implementation of the descent; all give the same words.
struct DescendKernel {
  const char* name;
  DescendFunction descend;
};

/// The implementations that this processor can run, the fastest first.
std::vector<DescendKernel> AvailableDescendKernels();

}  // namespace deja_view::internal
