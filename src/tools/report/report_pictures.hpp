#pragma once

#include "deja_view/lab/report/matches.hpp"

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace deja_view {

/// Half-size JPEGs of the images (`image_topic`) and virtual views (/virtual_cam0/frame) that
/// `wanted` names by stamp and view; -1 is the real image. Those that no bag holds, or that came
/// without an image, are left out. Throws InputError for a bag that can't be read.
report::Pictures ReadPictures(const std::vector<std::filesystem::path>& bags,
                              const std::string& image_topic,
                              const std::set<std::pair<std::int64_t, int>>& wanted);

}  // namespace deja_view
