#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/nerf/posed_images.hpp"
#include "deja_view/views/depth_warp_renderer.hpp"

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace deja_view {

/// 16-bit depth maps of a flight's images.
struct DepthMapFiles {
  std::filesystem::path directory;  ///< nerf::ListDepthMaps; empty: none
  std::string along = "axis";  ///< what they measure: along the optical axis or the pixel's ray
  double unit_m = 1e-3;
};

/// The depth maps of a flight's images, found by their stamps.
class DepthMaps {
 public:
  /// `camera` took the images. Throws InputError for a folder that holds no depth maps.
  DepthMaps(const DepthMapFiles& files, const std::shared_ptr<const Camera>& camera);

  bool Has(std::int64_t stamp_ns) const;
  /// How many of the images of `where` have one. Throws InputError when none has.
  std::size_t CountImages(const std::vector<std::int64_t>& image_stamps_ns,
                          const std::filesystem::path& where) const;
  /// For the pixels of the image; nothing where it has no map. Throws InputError that names a file
  /// that is no 16-bit image of its camera's size.
  std::optional<RangeMap> Find(std::int64_t stamp_ns) const;
  /// A line that tells these maps from others.
  std::string Describe() const;

 private:
  DepthMapFiles files_;
  std::map<std::int64_t, nerf::PosedImage> maps_;  // by KeyframeAssembler::Key
};

/// Null for an empty directory.
std::shared_ptr<const DepthMaps> OpenDepthMaps(const DepthMapFiles& files,
                                               const std::shared_ptr<const Camera>& camera);

}  // namespace deja_view
