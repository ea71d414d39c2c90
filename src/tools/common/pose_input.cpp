#include "common/pose_input.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/io/trajectory_file.hpp"

#include <cmath>
#include <utility>

#ifdef DEJA_VIEW_WITH_ROS
#include "deja_view/ros/bag/bag_poses.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
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

PoseSource ReadFlightPoses(const std::string& file_or_topic,
                           const std::filesystem::path& bag,
                           bool is_of_camera) {
  std::error_code error;
  if (std::filesystem::exists(file_or_topic, error) ||
      file_or_topic.find(".bag:/") != std::string::npos) {
    return ReadPoses(file_or_topic, is_of_camera);
  }
  bool is_topic = !file_or_topic.empty() && file_or_topic.front() == '/';
#ifdef DEJA_VIEW_WITH_ROS
  is_topic = is_topic && !bag.empty() && BagReader(bag).HasTopic(file_or_topic);
#endif
  if (!is_topic) {
    ThrowInputError(
        "{}: no such file or topic: expected poses (TUM, data.csv of EuRoC, vins_result of "
        "VINS-Mono, a model of COLMAP), BAG:/topic{}",
        file_or_topic,
        bag.empty() ? "" : ", or a topic of " + bag.string());
  }
  return ReadPoses(bag, file_or_topic, is_of_camera);
}

nlohmann::ordered_json ToJson(const RobustAlignment& alignment) {
  nlohmann::ordered_json json;
  json["pairs"] = alignment.pairs;
  json["inlier_share"] = alignment.inlier_share;
  json["rmse_m"] = alignment.rmse_m;
  json["max_m"] = alignment.max_m;
  json["rotation_deg"] = ToDegrees(alignment.rotation_rad);
  json["scale"] = alignment.A_B.scale;
  return json;
}

}  // namespace deja_view
