#pragma once

#include <filesystem>

namespace deja_view::internal {

/// Walks the records of a bag (format 2.0) and checks that every length, offset and reference stays
/// within what is there: rosbag_storage reads beyond its buffers when they do not. Compressed
/// chunks are not looked into; their checksums guard them. Reads record headers only, so that it
/// takes milliseconds.
///
/// Throws InputError that names the path, the position and what was expected.
void CheckBag(const std::filesystem::path& path);

}  // namespace deja_view::internal
