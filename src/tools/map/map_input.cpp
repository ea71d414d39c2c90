#include "map/map_input.hpp"

#include "deja_view/base/hash.hpp"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace deja_view {
namespace {

/// Of what the stages' figures are; another number where they change, so that none made before is
/// taken for one of today's.
constexpr int kFigures = 2;

std::string DescribePoses(const HostChoice& host) {
  std::string text = host.poses + " of " + host.poses_of;
  std::vector<std::filesystem::path> files;
  if (std::filesystem::is_directory(host.poses)) {  // a model of COLMAP
    for (const auto& entry : std::filesystem::directory_iterator(host.poses)) {
      files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
  } else {
    files.emplace_back(host.poses);
  }
  for (const std::filesystem::path& file : files) {
    if (std::filesystem::is_regular_file(file)) {
      text += fmt::format(" {:016x}", Hash64OfFile(file));
    }
  }
  return text;
}

}  // namespace

std::uint64_t HashOfMapInput(const MapRequest& request) {
  std::string text = fmt::format("{} {} {} {} {}",
                                 kFigures,
                                 Hash64OfFile(request.bag),
                                 Hash64OfFile(request.camera),
                                 EnumToString(request.host.host),
                                 request.host.odometry_topic);
  if (request.host.gravity != GravityPolicy::kGiven) {
    text += fmt::format(" {}", EnumToString(request.host.gravity));
  }
  if (!request.add.empty()) {
    text += fmt::format(" {:016x} {:016x}",
                        Hash64OfFile(request.add / "map.dvm"),
                        Hash64OfFile(request.add / "field.dvn"));
  }
  if (!request.host.poses.empty()) {
    text += " " + DescribePoses(request.host);
  }
  return Hash64(text);
}

}  // namespace deja_view
