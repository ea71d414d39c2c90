#include "deja_view/ros/bag/bag_reader.hpp"

#include "deja_view/base/input_file.hpp"

#include <algorithm>
#include <exception>
#include <map>
#include <utility>

#include "bag_check.hpp"
#include "message_layout.hpp"

#include <rosbag/bag.h>
#include <rosbag/view.h>

namespace deja_view {
namespace {

// An exception of the visitor, carried through the code that turns the bag library's into
// InputErrors.
struct VisitorError {
  std::exception_ptr error;
};

std::string ListTopics(const std::vector<BagReader::Topic>& topics) {
  std::string text;
  for (const BagReader::Topic& topic : topics) {
    text += fmt::format(
        "{}{} ({}, {})", text.empty() ? "" : ", ", topic.name, topic.type, topic.messages);
  }
  return text.empty() ? "no topics at all" : text;
}

// Of the few types that this package reads.
const internal::MessageLayout& LayoutOf(const std::string& type, const std::string& definition) {
  thread_local std::map<std::string, internal::MessageLayout> layouts;
  return layouts.try_emplace(type, type, definition).first->second;
}

}  // namespace

void internal::CheckLengths(const rosbag::MessageInstance& instance,
                            const std::string& type,
                            const std::string& definition) {
  std::vector<std::uint8_t> bytes(instance.size());
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  instance.write(stream);
  const std::string overrun = LayoutOf(type, definition).FindOverrun(bytes.data(), bytes.size());
  if (!overrun.empty()) {
    throw ros::serialization::StreamOverrunException(
        fmt::format("{}: a message of {} bytes whose field '{}' says it has more",
                    instance.getTopic(),
                    bytes.size(),
                    overrun));
  }
}

BagReader::BagReader(const std::filesystem::path& path)
    : path_(path), bag_(std::make_unique<rosbag::Bag>()) {
  CheckInputFile(path);
  internal::CheckBag(path);
  try {
    bag_->open(path.string(), rosbag::bagmode::Read);
    rosbag::View view(*bag_);
    std::map<std::pair<std::string, std::string>, std::int64_t> counts;
    for (const rosbag::ConnectionInfo* connection : view.getConnections()) {
      rosbag::View one(
          *bag_, [connection](const rosbag::ConnectionInfo* c) { return c->id == connection->id; });
      counts[{connection->topic, connection->datatype}] += one.size();
    }
    for (const auto& [key, count] : counts) {
      topics_.push_back({key.first, key.second, count});
    }
  } catch (const std::exception& e) {
    ThrowDamaged(e.what());
  }
}

BagReader::~BagReader() = default;

bool BagReader::HasTopic(const std::string& name) const {
  return !TypeOf(name).empty();
}

std::string BagReader::TypeOf(const std::string& name) const {
  for (const Topic& topic : topics_) {
    if (topic.name == name) {
      return topic.type;
    }
  }
  return {};
}

void BagReader::RequireTopic(const std::string& name, const std::vector<std::string>& types) const {
  const std::string type = TypeOf(name);
  if (type.empty()) {
    ThrowInputError("{}: no topic '{}': the bag has {}", path_.string(), name, ListTopics(topics_));
  }
  if (std::find(types.begin(), types.end(), type) == types.end()) {
    ThrowInputError("{}: topic '{}' is of type {}: expected {}",
                    path_.string(),
                    name,
                    type,
                    fmt::join(types, " or "));
  }
}

std::int64_t BagReader::Read(
    const std::vector<std::string>& names,
    const std::function<void(const rosbag::MessageInstance&)>& visit) const {
  return Read(names, nullptr, {}, visit);
}

std::int64_t BagReader::Read(
    const std::vector<std::string>& names,
    const BagReader* beside,
    const std::vector<std::string>& beside_names,
    const std::function<void(const rosbag::MessageInstance&)>& visit) const {
  return Visit(
      [&](rosbag::View* view) {
        view->addQuery(*bag_, rosbag::TopicQuery(names));
        if (beside != nullptr) {
          view->addQuery(*beside->bag_, rosbag::TopicQuery(beside_names));
        }
      },
      visit);
}

std::int64_t BagReader::ReadAll(
    const std::function<void(const rosbag::MessageInstance&)>& visit) const {
  return Visit([this](rosbag::View* view) { view->addQuery(*bag_); }, visit);
}

std::int64_t BagReader::Visit(
    const std::function<void(rosbag::View*)>& query,
    const std::function<void(const rosbag::MessageInstance&)>& visit) const {
  std::int64_t count = 0;
  try {
    rosbag::View view;
    query(&view);
    for (const rosbag::MessageInstance& instance : view) {
      ++count;
      try {
        visit(instance);
      } catch (const ros::Exception&) {
        throw;  // the bag's content can't be deserialised
      } catch (...) {
        throw VisitorError{std::current_exception()};
      }
    }
  } catch (const VisitorError& e) {
    std::rethrow_exception(e.error);
  } catch (const std::exception& e) {
    ThrowDamaged(e.what());
  }
  return count;
}

void BagReader::ThrowDamaged(const std::string& what) const {
  ThrowInputError(
      "{}: the bag is damaged or truncated, or is no bag ({}): expected a ROS bag of version 2.0",
      path_.string(),
      what);
}

}  // namespace deja_view
