#include "deja_view/ros/messages/tf_poses.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/ros/messages/conversions.hpp"

#include <algorithm>

#include <tf2/exceptions.h>

namespace deja_view {
namespace {

constexpr const char* kPrefix = "tf:";

// Less is out of order, and tf2 sorts it in.
constexpr std::int64_t kMemoryNs = 5'000'000'000;

// tf2 knows no names with a slash before them, which tf's first version wrote.
std::string FrameName(const std::string& name) {
  return name.substr(std::min(name.size(), name.find_first_not_of('/')));
}

geometry_msgs::Pose PoseOf(const geometry_msgs::Transform& transform) {
  geometry_msgs::Pose pose;
  pose.position.x = transform.translation.x;
  pose.position.y = transform.translation.y;
  pose.position.z = transform.translation.z;
  pose.orientation = transform.rotation;
  return pose;
}

}  // namespace

std::optional<TfFrames> ParseTfFrames(const std::string& topic) {
  const std::string prefix(kPrefix);
  if (topic.compare(0, prefix.size(), prefix) != 0) {
    return std::nullopt;
  }
  const std::size_t comma = topic.find(',');
  TfFrames frames;
  if (comma != std::string::npos) {
    frames.world = FrameName(topic.substr(prefix.size(), comma - prefix.size()));
    frames.body = FrameName(topic.substr(comma + 1));
  }
  if (frames.world.empty() || frames.body.empty() || frames.body.find(',') != std::string::npos) {
    ThrowInputError("'{}': expected {}WORLD,BODY with the names of two frames", topic, kPrefix);
  }
  return frames;
}

TfPoses::TfPoses(const TfFrames& frames) : frames_(frames) {
  Forget();
}

void TfPoses::Forget() {
  buffer_ = std::make_unique<tf2::BufferCore>();
  last_ns_ = -1;
  newest_ns_.clear();
  Set(static_, true);
}

void TfPoses::Set(const tf2_msgs::TFMessage& message, bool is_static) {
  for (geometry_msgs::TransformStamped transform : message.transforms) {
    transform.header.frame_id = FrameName(transform.header.frame_id);
    transform.child_frame_id = FrameName(transform.child_frame_id);
    const std::string link = transform.header.frame_id + " -> " + transform.child_frame_id;
    FromPose(PoseOf(transform.transform), link);
    links_.insert(link);
    buffer_->setTransform(transform, "", is_static);
    if (!is_static) {
      std::int64_t& newest_ns = newest_ns_[transform.child_frame_id];
      newest_ns = std::max(newest_ns, ToNanoseconds(transform.header.stamp));
    }
  }
}

void TfPoses::AddStatic(const tf2_msgs::TFMessage& message) {
  static_.transforms.insert(
      static_.transforms.end(), message.transforms.begin(), message.transforms.end());
  Set(message, true);
}

bool TfPoses::GoesBack(const tf2_msgs::TFMessage& message) const {
  return std::any_of(
      message.transforms.begin(), message.transforms.end(), [this](const auto& transform) {
        const auto last = newest_ns_.find(FrameName(transform.child_frame_id));
        return last != newest_ns_.end() &&
               ToNanoseconds(transform.header.stamp) < last->second - kMemoryNs;
      });
}

std::optional<StampedPose> TfPoses::Add(const tf2_msgs::TFMessage& message) {
  if (GoesBack(message)) {
    Forget();
  }
  Set(message, false);
  try {
    const geometry_msgs::TransformStamped transform =
        buffer_->lookupTransform(frames_.world, frames_.body, ros::Time(0));
    const std::int64_t stamp_ns = ToNanoseconds(transform.header.stamp);
    if (stamp_ns <= last_ns_) {
      return std::nullopt;
    }
    last_ns_ = stamp_ns;
    return StampedPose{stamp_ns, FromPose(PoseOf(transform.transform), frames_.body)};
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

std::string TfPoses::Describe() const {
  return fmt::format("no transform from {} to {}; there {}",
                     frames_.world,
                     frames_.body,
                     links_.empty() ? "are none" : fmt::format("are {}", fmt::join(links_, ", ")));
}

}  // namespace deja_view
