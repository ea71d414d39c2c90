#pragma once

#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace deja_view {

/// A topic without which there is nothing to do.
struct NeededTopic {
  std::string name;
  std::string type;        ///< e.g. sensor_msgs/Image
  bool is_stream = false;  ///< must never fall silent; others, as keyframes, only have to begin
};

/// Notices which needed topics are silent, and words the warnings: one after kFirstSeconds, again
/// every kAgainSeconds. Times are seconds of any steady clock. Thread-safe.
class TopicWatch {
 public:
  static constexpr double kFirstSeconds = 3;
  static constexpr double kAgainSeconds = 10;

  TopicWatch(std::vector<NeededTopic> topics, double now_s);

  void Hear(const std::string& topic, double now_s);

  /// Names of the topics that have been silent for kFirstSeconds.
  std::vector<std::string> Silent(double now_s) const;

  /// A warning for each silent topic whose time has come. `published` are the types of the topics
  /// that somebody publishes, by name.
  std::vector<std::string> Warn(double now_s, const std::map<std::string, std::string>& published);

 private:
  struct Watched {
    NeededTopic topic;
    bool is_heard = false;
    double last_s = 0;    ///< message, or the start
    double warned_s = 0;  ///< of this silence; only where it was warned of
    bool is_warned = false;
  };
  static bool IsSilent(const Watched& watched, double now_s);

  mutable std::mutex mutex_;
  std::vector<Watched> topics_;
};

}  // namespace deja_view
