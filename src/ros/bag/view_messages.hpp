#pragma once

#include "deja_view/base/shard.hpp"
#include "deja_view/ros/bag/bag_writer.hpp"
#include "deja_view/ros/bag/view_store.hpp"
#include "deja_view/ros/bag/view_topics.hpp"

#include <cstdint>
#include <string>

namespace deja_view::internal {

/// Writes the messages of one source behind its image: each 1 ns after the one before.
void WriteViews(const SourceResult& result,
                const ViewTopics& topics,
                bool plain_topics,
                BagWriter* bag);

/// What a bag of views says about itself.
struct PartLabel {
  Shard shard;
  Shard sub_map;
  std::string sub_map_settings;  ///< ViewSubMap::settings
  std::uint64_t job_hash = 0;    ///< of bag, poses and settings
  std::string settings;
};

/// "part 1 of 3", "part 0 of 1 of sub-map 1 of 2".
std::string NameOf(const PartLabel& label);

std::string FormatLabel(const PartLabel& label);
/// Throws InputError that names `path` for other text.
PartLabel ParseLabel(const std::string& text, const std::string& path);

}  // namespace deja_view::internal
