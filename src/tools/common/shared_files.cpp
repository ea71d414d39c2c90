#include "common/shared_files.hpp"

#include "deja_view/base/check.hpp"

#include <cstdlib>
#include <vector>

namespace deja_view {

namespace fs = std::filesystem;

fs::path FindSharedFile(const std::string& name) {
  std::vector<fs::path> directories;
  if (const char* share = std::getenv("DEJA_VIEW_SHARE")) {
    directories.emplace_back(share);
  }
  directories.emplace_back(DEJA_VIEW_SOURCE_CONFIG);
  directories.emplace_back(DEJA_VIEW_INSTALLED_CONFIG);
  for (const fs::path& directory : directories) {
    fs::path file = directory / name;
    if (fs::exists(file)) {
      return file;
    }
  }
  ThrowInputError("no {} under {}, {} or $DEJA_VIEW_SHARE: name the file itself",
                  name,
                  DEJA_VIEW_SOURCE_CONFIG,
                  DEJA_VIEW_INSTALLED_CONFIG);
}

}  // namespace deja_view
