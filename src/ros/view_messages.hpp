#pragma once

#include "deja_view/ros/bag_writer.hpp"
#include "deja_view/ros/view_bag.hpp"

#include <cstdint>

namespace deja_view::internal {

/// Writes the messages of one source behind its image: each 1 ns after the one before.
void WriteViews(const SourceResult& result,
                const ViewTopics& topics,
                bool plain_topics,
                BagWriter* bag);

/// What a bag of views says about itself.
struct PartLabel {
  ViewShard shard;
  std::uint64_t job_hash = 0;  ///< of bag, poses and settings
  std::string settings;
};

std::string FormatLabel(const PartLabel& label);
/// Throws InputError that names `path` for other text.
PartLabel ParseLabel(const std::string& text, const std::string& path);

}  // namespace deja_view::internal
