#include "view_messages.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/quote.hpp"
#include "deja_view/ros/messages/virtual_frame_conversion.hpp"

#include <cstdio>

#include <geometry_msgs/PoseStamped.h>
#include <sensor_msgs/CameraInfo.h>

namespace deja_view::internal {
namespace {

// An empty distortion model for MEI, which ROS has no name for.
sensor_msgs::CameraInfo ToCameraInfo(const VirtualFrame& frame) {
  sensor_msgs::CameraInfo info;
  info.header = frame.header;
  info.width = frame.width;
  info.height = frame.height;
  info.D = frame.distortion;
  const std::size_t first = frame.projection.size() - 4;  // behind MEI's xi
  info.K = {frame.projection[first],
            0,
            frame.projection[first + 2],
            0,
            frame.projection[first + 1],
            frame.projection[first + 3],
            0,
            0,
            1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.P = {info.K[0], 0, info.K[2], 0, 0, info.K[4], info.K[5], 0, 0, 0, 1, 0};
  if (frame.camera_model == "PINHOLE") {
    info.distortion_model = "plumb_bob";
    info.D.push_back(0);  // k3
  } else if (frame.camera_model == "KANNALA_BRANDT") {
    info.distortion_model = "equidistant";
  }
  return info;
}

void WritePlain(const VirtualFrame& frame,
                const ViewTopics& topics,
                std::int64_t* time_ns,
                BagWriter* bag) {
  const VirtualView view = FromVirtualFrame(frame, topics.frame);
  if (!view.image.empty()) {
    bag->Write(topics.image, ++*time_ns, ToImage(view.image, view.stamp_ns, frame.header.frame_id));
  }
  bag->Write(topics.camera_info, ++*time_ns, ToCameraInfo(frame));
  geometry_msgs::PoseStamped pose;
  pose.header = frame.header;
  pose.pose = frame.T_C_V;
  bag->Write(topics.pose, ++*time_ns, pose);
}

// Takes "# sub-map i of n: settings" off the beginning of a label's settings, where it is.
void ParseSubMap(const std::string& path, PartLabel* label) {
  int length = 0;
  std::string& text = label->settings;
  Shard& sub_map = label->sub_map;
  const int found =
      std::sscanf(text.c_str(), "# sub-map %d of %d: %n", &sub_map.index, &sub_map.count, &length);
  if (found < 1) {
    return;
  }
  const auto at = static_cast<std::size_t>(length);
  const std::size_t end = text.find('\n');
  if (found != 2 || length == 0 || end == std::string::npos || sub_map.count < 2 ||
      sub_map.index < 0 || sub_map.index >= sub_map.count) {
    ThrowInputError("{}: {}: expected '# sub-map i of n: settings'", path, Quote(text));
  }
  label->sub_map_settings = text.substr(at, end - at);
  text.erase(0, end + 1);
}

}  // namespace

void WriteViews(const SourceResult& result,
                const ViewTopics& topics,
                bool plain_topics,
                BagWriter* bag) {
  std::int64_t time_ns = result.recorded_ns;
  for (const VirtualFrame& frame : result.frames) {
    bag->Write(topics.frame, ++time_ns, frame);
    if (plain_topics) {
      WritePlain(frame, topics, &time_ns, bag);
    }
  }
}

std::string NameOf(const PartLabel& label) {
  std::string name = fmt::format("part {} of {}", label.shard.index, label.shard.count);
  if (label.sub_map.count > 1) {
    name += fmt::format(" of sub-map {} of {}", label.sub_map.index, label.sub_map.count);
  }
  return name;
}

std::string FormatLabel(const PartLabel& label) {
  std::string text = fmt::format(
      "# part {} of {}, job {:016x}\n", label.shard.index, label.shard.count, label.job_hash);
  if (label.sub_map.count > 1) {
    text += fmt::format("# sub-map {} of {}: {}\n",
                        label.sub_map.index,
                        label.sub_map.count,
                        label.sub_map_settings);
  }
  return text + label.settings;
}

PartLabel ParseLabel(const std::string& text, const std::string& path) {
  PartLabel label;
  int length = 0;
  unsigned long long hash = 0;
  const int found = std::sscanf(text.c_str(),
                                "# part %d of %d, job %16llx%n",
                                &label.shard.index,
                                &label.shard.count,
                                &hash,
                                &length);
  const auto at = static_cast<std::size_t>(length);
  if (found != 3 || at >= text.size() || text[at] != '\n' || label.shard.count < 1 ||
      label.shard.index < 0 || label.shard.index >= label.shard.count) {
    ThrowInputError("{}: settings that begin with {}: expected a part that views render made",
                    path,
                    Quote(text.substr(0, text.find('\n'))));
  }
  label.job_hash = hash;
  label.settings = text.substr(at + 1);
  ParseSubMap(path, &label);
  return label;
}

}  // namespace deja_view::internal
