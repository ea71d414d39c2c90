#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/nerf/posed_images.hpp"
#include "deja_view/ros/bag/view_flight.hpp"
#include "deja_view/views/depth_warp_renderer.hpp"

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "views/views_command.hpp"

namespace deja_view {

/// The depth maps of a flight's images, found by their stamps.
class DepthMaps {
 public:
  /// `camera` took the images. Throws InputError for a folder that holds no depth maps.
  DepthMaps(const DepthMapFiles& files, const std::shared_ptr<const Camera>& camera);

  bool Has(std::int64_t stamp_ns) const;
  /// How many images of a topic have one. Throws InputError when none has.
  std::size_t CountImages(const ViewFlight& flight, const std::string& topic) const;
  /// For the pixels of the image, which has a map. Throws InputError that names a file that is no
  /// 16-bit image of its camera's size.
  RangeMap Read(std::int64_t stamp_ns) const;
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
