#pragma once

#include <filesystem>
#include <functional>
#include <ostream>

namespace deja_view {

/// Writes `path` through a temporary name in the same directory, flushed to disk and then renamed,
/// so that a crash leaves either the old file or the new one, whole. Creates missing parent
/// directories. Throws InputError that names the path when it can't be written; the temporary is
/// then removed.
void WriteFileAtomically(const std::filesystem::path& path,
                         const std::function<void(std::ostream&)>& write);

}  // namespace deja_view
