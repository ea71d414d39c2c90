#pragma once

#include "deja_view/base/check.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <rosbag/message_instance.h>

namespace rosbag {
class Bag;
class View;
}  // namespace rosbag

namespace deja_view {

/// A recorded bag, read message by message in the order of recording: memory does not grow with the
/// bag's size beyond its index (about 100 bytes a message).
class BagReader {
 public:
  struct Topic {
    std::string name;
    std::string type;  ///< "sensor_msgs/Image"
    std::int64_t messages = 0;
  };

  /// Throws InputError, naming the path and the way out, when there is no such file, it is no bag,
  /// or the bag is truncated or was never closed.
  explicit BagReader(const std::filesystem::path& path);
  ~BagReader();

  const std::filesystem::path& path() const { return path_; }
  /// Sorted by name; a topic recorded with two types is listed twice.
  const std::vector<Topic>& topics() const { return topics_; }
  bool HasTopic(const std::string& name) const;
  /// Type of a topic, or "" when the bag has no such topic.
  std::string TypeOf(const std::string& name) const;

  /// Throws InputError that lists the bag's topics when `name` is not one of them, and one that
  /// names both types when its type is not in `types`.
  void RequireTopic(const std::string& name, const std::vector<std::string>& types) const;

  /// Calls `visit` for each message of `names`, in order of recording; topics that the bag lacks
  /// are passed over. Returns the number of messages. Throws InputError when the bag turns out to
  /// be damaged.
  std::int64_t Read(const std::vector<std::string>& names,
                    const std::function<void(const rosbag::MessageInstance&)>& visit) const;

  /// The same with the messages of `beside_names` from another bag between them, by the times of
  /// recording.
  std::int64_t Read(const std::vector<std::string>& names,
                    const BagReader* beside,
                    const std::vector<std::string>& beside_names,
                    const std::function<void(const rosbag::MessageInstance&)>& visit) const;

  /// As Read, for the messages of all topics.
  std::int64_t ReadAll(const std::function<void(const rosbag::MessageInstance&)>& visit) const;

 private:
  std::int64_t Visit(const std::function<void(rosbag::View*)>& query,
                     const std::function<void(const rosbag::MessageInstance&)>& visit) const;
  [[noreturn]] void ThrowDamaged(const std::string& what) const;

  std::filesystem::path path_;
  std::unique_ptr<rosbag::Bag> bag_;
  std::vector<Topic> topics_;
};

namespace internal {
/// Throws ros::Exception when lengths in the message, which is of the type and definition, say more
/// than it has bytes.
void CheckLengths(const rosbag::MessageInstance& instance,
                  const std::string& type,
                  const std::string& definition);
}  // namespace internal

/// The message as `Message`. Throws InputError, naming the topic and both types, when it is of
/// another, and ros::Exception, as roscpp, when it is cut off.
template <typename Message>
boost::shared_ptr<const Message> Instantiate(const rosbag::MessageInstance& instance) {
  if (!instance.isType<Message>()) {
    ThrowInputError("{}: message of type {}: expected {}",
                    instance.getTopic(),
                    instance.getDataType(),
                    ros::message_traits::datatype<Message>());
  }
  internal::CheckLengths(instance,
                         ros::message_traits::datatype<Message>(),
                         ros::message_traits::definition<Message>());
  return instance.instantiate<Message>();
}

}  // namespace deja_view
