#pragma once

#include "deja_view/host/host_kind.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/ros/messages/output_messages.hpp"

#include <filesystem>
#include <string>

#include <ros/node_handle.h>

namespace deja_view {

/// What the parameter server tells the node: files, directories, topics and frames. Everything else
/// is in the files.
struct NodeParameters {
  std::filesystem::path config_file;       ///< ~config_file: camera file, required
  std::filesystem::path vocabulary_file;   ///< ~vocabulary_file: required
  std::filesystem::path options_file;      ///< ~options_file: LoopFusionOptions; empty: defaults
  std::filesystem::path map_directory;     ///< ~map_directory: default pose_graph_save_path
  std::filesystem::path output_directory;  ///< ~output_directory: results at the end; empty: none
  std::string load_map_at_start;           ///< ~load_map_at_start: name of a map; empty: none
  std::string save_map_at_end;             ///< ~save_map_at_end: name of a map; empty: none
  HostKind host = HostKind::kVinsMono;     ///< ~host: vins_mono, vins_fusion, openvins or odometry
  GravityPolicy gravity = GravityPolicy::kGiven;  ///< ~gravity: given or estimate
  /// ~topics/image, keyframe_pose, ...: empty ones are the host's, the image's the YAML's
  VioTopics topics;
  bool compressed_images = false;  ///< ~compressed_images: the image topic is a CompressedImage's
  FrameNames frames;               ///< ~frames/map, vio, body, body_corrected
  std::string vins_namespace;      ///< ~vins_namespace: of VINS-Mono's outputs, "/pose_graph"

  /// `load_previous_pose_graph: 1` of the YAML: the map "previous" is loaded at the start if there
  /// is one.
  static constexpr const char* kPreviousMap = "previous";
};

/// Throws InputError that names a missing parameter, or one of another type.
NodeParameters ReadNodeParameters(const ros::NodeHandle& private_handle);

/// Fills in what the camera YAML gives: the image topic and the directory of maps. Throws
/// InputError when neither names an image topic.
void CompleteParameters(const VinsConfig& vins, NodeParameters* parameters);

}  // namespace deja_view
