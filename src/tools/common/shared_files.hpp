#pragma once

#include <filesystem>
#include <string>

namespace deja_view {

/// A file that the package ships, e.g. "vocabulary/brief.dvv": looked for in $DEJA_VIEW_SHARE,
/// beside the source tree that this was built from, then in the installed share directory. Throws
/// InputError that names these places.
std::filesystem::path FindSharedFile(const std::string& name);

}  // namespace deja_view
