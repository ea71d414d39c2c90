#include "deja_view/base/check.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/bag_writer.hpp"
#include "deja_view/ros/bag/view_bag.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "view_messages.hpp"

#include <std_msgs/String.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

// One share of the views, read back.
struct Part {
  std::unique_ptr<BagReader> bag;
  internal::PartLabel label;
  std::vector<rosbag::MessageInstance> messages;
};

Part ReadPart(const fs::path& path) {
  const ViewTopics topics;
  Part part;
  part.bag = std::make_unique<BagReader>(path);
  part.bag->RequireTopic(topics.settings, {"std_msgs/String"});
  part.bag->ReadAll([&part, &topics, &path](const rosbag::MessageInstance& instance) {
    if (instance.getTopic() == topics.settings) {
      part.label =
          internal::ParseLabel(Instantiate<std_msgs::String>(instance)->data, path.string());
    } else {
      part.messages.push_back(instance);
    }
  });
  return part;
}

// Parts by sub-map and share.
using PartIndices = std::set<std::pair<int, int>>;

void CheckComplete(const PartIndices& indices, internal::PartLabel label, const fs::path& path) {
  for (label.sub_map.index = 0; label.sub_map.index < label.sub_map.count; ++label.sub_map.index) {
    for (label.shard.index = 0; label.shard.index < label.shard.count; ++label.shard.index) {
      if (indices.count({label.sub_map.index, label.shard.index}) == 0) {
        ThrowInputError(
            "{}: {} is missing among those given", path.string(), internal::NameOf(label));
      }
    }
  }
}

void CheckParts(const std::vector<Part>& parts, const std::vector<fs::path>& paths) {
  PartIndices indices;
  std::map<int, std::string> settings;  // of the sub-maps
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const internal::PartLabel& label = parts[i].label;
    const internal::PartLabel& first = parts.front().label;
    if (label.job_hash != first.job_hash || label.settings != first.settings ||
        label.shard.count != first.shard.count || label.sub_map.count != first.sub_map.count ||
        settings.emplace(label.sub_map.index, label.sub_map_settings).first->second !=
            label.sub_map_settings) {
      ThrowInputError(
          "{}: made of another flight, with other settings or another number of parts "
          "than {}",
          paths[i].string(),
          paths.front().string());
    }
    if (!indices.insert({label.sub_map.index, label.shard.index}).second) {
      ThrowInputError("{}: {} is given twice", paths[i].string(), internal::NameOf(label));
    }
  }
  CheckComplete(indices, parts.front().label, paths.front());
}

// What the merged bag says about its views.
std::string MergedSettings(const std::vector<Part>& parts) {
  std::map<int, std::string> lines;  // by sub-map
  for (const Part& part : parts) {
    const internal::PartLabel& label = part.label;
    lines[label.sub_map.index] = label.sub_map.count == 1 ? ""
                                                          : fmt::format("# sub-map {} of {}: {}\n",
                                                                        label.sub_map.index,
                                                                        label.sub_map.count,
                                                                        label.sub_map_settings);
  }
  std::string text;
  for (const auto& [index, line] : lines) {
    text += line;
  }
  return text + parts.front().label.settings;
}

std::vector<const rosbag::MessageInstance*> SortByTime(const std::vector<Part>& parts) {
  std::vector<const rosbag::MessageInstance*> messages;
  for (const Part& part : parts) {
    for (const rosbag::MessageInstance& message : part.messages) {
      messages.push_back(&message);
    }
  }
  std::stable_sort(messages.begin(), messages.end(), [](const auto* a, const auto* b) {
    return a->getTime() < b->getTime();
  });
  return messages;
}

}  // namespace

ViewReport MergeViews(const ViewFlight& flight,
                      const std::vector<fs::path>& part_paths,
                      const fs::path& out,
                      bool views_only) {
  DEJA_VIEW_CHECK(!part_paths.empty());
  const ViewTopics topics;
  if (flight.HasTopic(topics.frame)) {
    ThrowInputError("{}: has virtual views on {} already: expected the bag of a flight",
                    flight.path().string(),
                    topics.frame);
  }
  std::vector<Part> parts;
  for (const fs::path& path : part_paths) {
    parts.push_back(ReadPart(path));
  }
  CheckParts(parts, part_paths);
  const std::vector<const rosbag::MessageInstance*> messages = SortByTime(parts);

  ViewReport report;
  BagWriter writer(out);
  auto next = messages.begin();
  const auto copy_next = [&] {
    if ((*next)->getTopic() == topics.frame) {
      ++report.views;
      report.bytes += (*next)->size();
    }
    writer.Copy(**next++);
  };
  bool is_first = true;
  flight.ReadAll([&](std::int64_t time_ns, const ViewFlight::WriteMessage& write) {
    if (is_first) {
      std_msgs::String settings;
      settings.data = MergedSettings(parts);
      writer.Write(topics.settings, time_ns, settings);
      is_first = false;
    }
    while (next != messages.end() && ToNanoseconds((*next)->getTime()) < time_ns) {
      copy_next();
    }
    if (!views_only) {
      write(&writer);
    }
  });
  while (next != messages.end()) {
    copy_next();
  }
  writer.Close();
  return report;
}

}  // namespace deja_view
