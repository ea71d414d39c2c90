#include "pose_input.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/io/trajectory_file.hpp"

#include <utility>

#ifdef DEJA_VIEW_WITH_ROS
#include "deja_view/ros/bag_poses.hpp"
#include "deja_view/ros/bag_reader.hpp"
#endif

namespace deja_view {

PoseSource ReadPoses(const std::filesystem::path& path,
                     const std::string& topic,
                     bool is_of_camera) {
  if (topic.empty()) {
    TrajectoryFile file = ReadTrajectoryFile(path);
    const bool is_colmap = file.format == TrajectoryFormat::kColmap;
    return {std::move(file.trajectory), is_of_camera || file.is_of_camera, !is_colmap};
  }
#ifdef DEJA_VIEW_WITH_ROS
  return {ReadBagPoses(BagReader(path), topic), is_of_camera, true};
#else
  ThrowInputError("{}: this build reads no bags (DEJA_VIEW_ROS=OFF)", path.string());
#endif
}

PoseSource ReadPoses(const std::string& file_or_topic, bool is_of_camera) {
  const std::string ending = ".bag";
  const std::size_t topic = file_or_topic.find(ending + ":/");
  if (topic == std::string::npos) {
    return ReadPoses(file_or_topic, "", is_of_camera);
  }
  const std::size_t colon = topic + ending.size();
  return ReadPoses(file_or_topic.substr(0, colon), file_or_topic.substr(colon + 1), is_of_camera);
}

}  // namespace deja_view
