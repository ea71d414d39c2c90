#include "deja_view/ros/node_parameters.hpp"

#include "deja_view/base/check.hpp"

namespace deja_view {
namespace {

template <typename T>
T Read(const ros::NodeHandle& handle,
       const std::string& name,
       const T& fallback,
       const char* type) {
  T value = fallback;
  if (handle.hasParam(name) && !handle.getParam(name, value)) {
    ThrowInputError("parameter {}: expected {}", handle.resolveName(name), type);
  }
  return value;
}

std::string ReadText(const ros::NodeHandle& handle,
                     const std::string& name,
                     const std::string& fallback = {}) {
  return Read<std::string>(handle, name, fallback, "text");
}

std::string ReadRequired(const ros::NodeHandle& handle, const std::string& name) {
  std::string value = ReadText(handle, name);
  if (value.empty()) {
    ThrowInputError("parameter {} is missing: expected a file", handle.resolveName(name));
  }
  return value;
}

}  // namespace

NodeParameters ReadNodeParameters(const ros::NodeHandle& handle) {
  NodeParameters p;
  p.config_file = ReadRequired(handle, "config_file");
  p.vocabulary_file = ReadRequired(handle, "vocabulary_file");
  p.options_file = ReadText(handle, "options_file");
  p.map_directory = ReadText(handle, "map_directory");
  p.output_directory = ReadText(handle, "output_directory");
  p.load_map_at_start = ReadText(handle, "load_map_at_start");
  p.save_map_at_end = ReadText(handle, "save_map_at_end");
  p.compressed_images = Read<bool>(handle, "compressed_images", false, "true or false");
  p.vins_namespace = ReadText(handle, "vins_namespace", "/pose_graph");
  p.topics.image = ReadText(handle, "topics/image");
  const auto read_topic = [&handle](const char* name, std::string* topic) {
    *topic = ReadText(handle, std::string("topics/") + name, *topic);
  };
  read_topic("keyframe_pose", &p.topics.keyframe_pose);
  read_topic("keyframe_point", &p.topics.keyframe_point);
  read_topic("extrinsic", &p.topics.extrinsic);
  read_topic("odometry", &p.topics.odometry);
  read_topic("imu_propagate", &p.topics.imu_propagate);
  read_topic("relo_relative_pose", &p.topics.relo_relative_pose);
  p.frames.map = ReadText(handle, "frames/map", p.frames.map);
  p.frames.vio = ReadText(handle, "frames/vio", p.frames.vio);
  p.frames.body = ReadText(handle, "frames/body", p.frames.body);
  return p;
}

void CompleteParameters(const VinsConfig& vins, NodeParameters* parameters) {
  if (parameters->topics.image.empty()) {
    parameters->topics.image = vins.image_topic;
  }
  if (parameters->map_directory.empty()) {
    parameters->map_directory = vins.pose_graph_save_path;
  }
}

}  // namespace deja_view
