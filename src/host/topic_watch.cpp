#include "deja_view/host/topic_watch.hpp"

#include <utility>

#include <fmt/format.h>

namespace deja_view {
namespace {

std::string Reason(const NeededTopic& topic, const std::map<std::string, std::string>& published) {
  const auto found = published.find(topic.name);
  if (found == published.end()) {
    return "nobody publishes it";
  }
  if (found->second != topic.type) {
    return fmt::format("it is published as {}, expected {}", found->second, topic.type);
  }
  return "its publisher is silent";
}

}  // namespace

TopicWatch::TopicWatch(std::vector<NeededTopic> topics, double now_s) {
  for (NeededTopic& topic : topics) {
    topics_.push_back({std::move(topic), false, now_s, 0, false});
  }
}

void TopicWatch::Hear(const std::string& topic, double now_s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (Watched& watched : topics_) {
    if (watched.topic.name == topic) {
      watched.is_heard = true;
      watched.last_s = now_s;
      watched.is_warned = false;
    }
  }
}

std::vector<std::string> TopicWatch::Silent(double now_s) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<std::string> names;
  for (const Watched& watched : topics_) {
    if (IsSilent(watched, now_s)) {
      names.push_back(watched.topic.name);
    }
  }
  return names;
}

std::vector<std::string> TopicWatch::Warn(double now_s,
                                          const std::map<std::string, std::string>& published) {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<std::string> warnings;
  for (Watched& watched : topics_) {
    const bool is_due = !watched.is_warned || now_s - watched.warned_s >= kAgainSeconds;
    if (IsSilent(watched, now_s) && is_due) {
      warnings.push_back(fmt::format("no message on {} for {:.0f} s: {}",
                                     watched.topic.name,
                                     now_s - watched.last_s,
                                     Reason(watched.topic, published)));
      watched.is_warned = true;
      watched.warned_s = now_s;
    }
  }
  return warnings;
}

bool TopicWatch::IsSilent(const Watched& watched, double now_s) {
  return (watched.topic.is_stream || !watched.is_heard) && now_s - watched.last_s >= kFirstSeconds;
}

}  // namespace deja_view
