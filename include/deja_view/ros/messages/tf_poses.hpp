#pragma once

#include "deja_view/host/odometry_input.hpp"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include <tf2_msgs/TFMessage.h>

#include <tf2/buffer_core.h>

namespace deja_view {

/// Two frames of tf between which an odometry's pose is.
struct TfFrames {
  std::string world;
  std::string body;
};

/// The frames of "tf:WORLD,BODY", which stands where a topic of poses may; nothing for a topic.
/// Throws InputError for what begins so and names no two frames.
std::optional<TfFrames> ParseTfFrames(const std::string& topic);

/// The poses of a body in the transforms of /tf and /tf_static, through whatever frames lie
/// between the two: one for each new stamp at which all of these are known, those of a slower
/// transform interpolated. Stamps that go back (a bag that is played again, an odometry that starts
/// anew) forget what came before.
class TfPoses {
 public:
  static constexpr const char* kTopic = "/tf";
  static constexpr const char* kStaticTopic = "/tf_static";

  explicit TfPoses(const TfFrames& frames);

  void AddStatic(const tf2_msgs::TFMessage& message);
  /// The body's new pose in the world, if this message completes one. Throws InputError for a
  /// transform that is none.
  std::optional<StampedPose> Add(const tf2_msgs::TFMessage& message);

  bool has_pose() const { return last_ns_ >= 0; }

  /// What is known of the frames, for a message: "no transform from ... to ...; there are ...".
  std::string Describe() const;

 private:
  void Set(const tf2_msgs::TFMessage& message, bool is_static);
  bool GoesBack(const tf2_msgs::TFMessage& message) const;
  void Forget();

  TfFrames frames_;
  std::unique_ptr<tf2::BufferCore> buffer_;        ///< neither copied nor moved
  tf2_msgs::TFMessage static_;                     ///< all that came
  std::set<std::string> links_;                    ///< "parent -> child"
  std::map<std::string, std::int64_t> newest_ns_;  ///< stamps of the transforms, by child
  std::int64_t last_ns_ = -1;                      ///< of the body's last pose
};

}  // namespace deja_view
