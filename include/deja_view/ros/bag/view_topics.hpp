#pragma once

#include <string>

namespace deja_view {

/// Topics of the virtual views.
struct ViewTopics {
  std::string frame = "/virtual_cam0/frame";        ///< deja_view/VirtualFrame
  std::string settings = "/virtual_cam0/settings";  ///< std_msgs/String, once: what made them
  std::string image = "/virtual_cam0/image_raw";    ///< the plain topics
  std::string camera_info = "/virtual_cam0/camera_info";
  std::string pose = "/virtual_cam0/pose";
};

}  // namespace deja_view
