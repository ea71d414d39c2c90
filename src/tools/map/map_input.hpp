#pragma once

#include <cstdint>

#include "map/map_command.hpp"

namespace deja_view {

/// Of what a map's first stage is made from: the files' content and how they are read. Throws
/// InputError for a file that can't be read.
std::uint64_t HashOfMapInput(const MapRequest& request);

}  // namespace deja_view
