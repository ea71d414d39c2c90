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

/// Writes the index of the nearest of `centre_count` centres (at most 256) for each descriptor to
/// `labels`.
using AssignFunction = void (*)(const Descriptor* descriptors,
                                std::size_t count,
                                const Descriptor* centres,
                                std::uint32_t centre_count,
                                std::uint8_t* labels);

/// Lowers distances[i] to the Hamming distance of descriptor i from `centre` where that is less.
using LowerFunction = void (*)(const Descriptor* descriptors,
                               std::size_t count,
                               const Descriptor& centre,
                               std::uint16_t* distances);

/// One implementation; all give the same results. Of equally near centres or children the first is
/// taken.
struct DescendKernel {
  DescendFunction descend;
  AssignFunction assign;
  LowerFunction lower;
};

/// The fastest that this processor can run; the plain loop in builds without Highway.
DescendKernel ChooseDescendKernel();

/// The plain loop, which the others are tested against.
DescendKernel PortableDescendKernel();

}  // namespace deja_view::internal
