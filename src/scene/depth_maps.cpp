#include "deja_view/scene/depth_maps.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"
#include "deja_view/host/keyframe_assembler.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include <algorithm>

namespace deja_view {

DepthMaps::DepthMaps(const DepthMapFiles& files, const std::shared_ptr<const Camera>& camera)
    : files_(files) {
  for (nerf::PosedImage& map :
       nerf::ListDepthMaps(files.directory, camera, files.unit_m, files.along == "ray")) {
    maps_[KeyframeAssembler::Key(map.stamp_ns)] = std::move(map);
  }
}

bool DepthMaps::Has(std::int64_t stamp_ns) const {
  return maps_.count(KeyframeAssembler::Key(stamp_ns)) > 0;
}

std::size_t DepthMaps::CountImages(const std::vector<std::int64_t>& image_stamps_ns,
                                   const std::filesystem::path& where) const {
  const auto count = std::count_if(image_stamps_ns.begin(),
                                   image_stamps_ns.end(),
                                   [this](std::int64_t stamp_ns) { return Has(stamp_ns); });
  if (count == 0) {
    ThrowInputError("{}: none of its {} depth maps has the stamp of one of the {} images of {}",
                    files_.directory.string(),
                    maps_.size(),
                    image_stamps_ns.size(),
                    where.string());
  }
  return static_cast<std::size_t>(count);
}

std::optional<RangeMap> DepthMaps::Find(std::int64_t stamp_ns) const {
  const auto map = maps_.find(KeyframeAssembler::Key(stamp_ns));
  return map == maps_.end() ? std::nullopt
                            : std::optional(DensifyDepthImage(nerf::ReadImageDepth(map->second)));
}

std::string DepthMaps::Describe() const {
  std::string text;
  for (const auto& [key, map] : maps_) {
    std::error_code error;
    text += fmt::format("{} {}\n", key, std::filesystem::file_size(map.depth.path, error));
  }
  return fmt::format(
      "depth maps: {} {} {} {:016x}\n", maps_.size(), files_.along, files_.unit_m, Hash64(text));
}

std::shared_ptr<const DepthMaps> OpenDepthMaps(const DepthMapFiles& files,
                                               const std::shared_ptr<const Camera>& camera) {
  return files.directory.empty() ? nullptr : std::make_shared<DepthMaps>(files, camera);
}

}  // namespace deja_view
