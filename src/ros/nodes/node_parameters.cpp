#include "deja_view/ros/nodes/node_parameters.hpp"

#include "parameters.hpp"

namespace deja_view {
namespace {

template <typename Enum>
Enum ReadEnum(const ros::NodeHandle& handle, const std::string& name, Enum fallback) {
  const std::string text = internal::ReadText(handle, name, EnumToString(fallback));
  const auto value = EnumFromString<Enum>(text);
  if (!value) {
    ThrowInputError(
        "parameter {}: '{}': expected {}", handle.resolveName(name), text, EnumNameList<Enum>());
  }
  return *value;
}

}  // namespace

NodeParameters ReadNodeParameters(const ros::NodeHandle& handle) {
  using internal::ReadRequired;
  using internal::ReadText;
  NodeParameters p;
  p.config_file = ReadRequired(handle, "config_file");
  p.vocabulary_file = ReadRequired(handle, "vocabulary_file");
  p.options_file = ReadText(handle, "options_file");
  p.map_directory = ReadText(handle, "map_directory");
  p.output_directory = ReadText(handle, "output_directory");
  p.load_map_at_start = ReadText(handle, "load_map_at_start");
  p.save_map_at_end = ReadText(handle, "save_map_at_end");
  p.compressed_images =
      internal::ReadParameter<bool>(handle, "compressed_images", false, "true or false");
  p.vins_namespace = ReadText(handle, "vins_namespace", "/pose_graph");
  p.host = ReadEnum(handle, "host", HostKind::kVinsMono);
  p.gravity = ReadEnum(handle, "gravity", GravityPolicy::kGiven);
  CheckGravity(p.host, p.gravity, "parameter " + handle.resolveName("gravity"));
  p.topics = TopicsOf(p.host);
  p.topics.image = ReadText(handle, "topics/image");
  const auto read_topic = [&handle](const char* name, std::string* topic) {
    const std::string given = ReadText(handle, std::string("topics/") + name);
    *topic = given.empty() ? *topic : given;
  };
  read_topic("keyframe_pose", &p.topics.keyframe_pose);
  read_topic("keyframe_point", &p.topics.keyframe_point);
  read_topic("extrinsic", &p.topics.extrinsic);
  read_topic("odometry", &p.topics.odometry);
  read_topic("imu_propagate", &p.topics.imu_propagate);
  read_topic("relo_relative_pose", &p.topics.relo_relative_pose);
  p.topics.virtual_frame = ReadText(handle, "topics/virtual_frame", p.topics.virtual_frame);
  p.frames.map = ReadText(handle, "frames/map", p.frames.map);
  p.frames.vio = ReadText(handle, "frames/vio", p.frames.vio);
  p.frames.body = ReadText(handle, "frames/body", p.frames.body);
  p.frames.body_corrected = ReadText(handle, "frames/body_corrected", p.frames.body_corrected);
  return p;
}

void CompleteParameters(const VinsConfig& vins, NodeParameters* parameters) {
  parameters->topics.image =
      RequireImageTopic(vins, parameters->config_file, parameters->topics.image);
  if (parameters->map_directory.empty()) {
    parameters->map_directory = vins.pose_graph_save_path;
  }
}

}  // namespace deja_view
