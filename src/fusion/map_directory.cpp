#include "deja_view/fusion/map_directory.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "safe_name.hpp"

namespace deja_view {
namespace {

namespace fs = std::filesystem;

void CheckNoLink(const fs::path& path, const std::string& name) {
  std::error_code error;
  if (fs::is_symlink(fs::symlink_status(path, error))) {
    ThrowInputError(
        "map '{}': {} is a link: expected a directory or file of its own", name, path.string());
  }
}

}  // namespace

MapDirectory::MapDirectory(fs::path root) : root_(std::move(root)) {}

fs::path MapDirectory::Resolve(const std::string& name) const {
  internal::CheckName("map", name);
  const fs::path path = root_ / name;
  CheckNoLink(path, name);
  std::error_code error;
  if (fs::exists(path, error) && !fs::is_directory(path, error)) {
    ThrowInputError("map '{}': {} is no directory", name, path.string());
  }
  for (fs::recursive_directory_iterator entry(path, error), end; !error && entry != end;
       entry.increment(error)) {
    CheckNoLink(entry->path(), name);
  }
  return path;
}

fs::path MapDirectory::ResolveExisting(const std::string& name) const {
  fs::path path = Resolve(name);
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    ThrowInputError("map '{}': not in {}: expected one of {}", name, root_.string(), ListMaps());
  }
  return path;
}

std::string MapDirectory::ListMaps() const {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(root_, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->is_directory(error)) {
      names.push_back(entry->path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names.empty() ? "no maps at all" : fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace deja_view
