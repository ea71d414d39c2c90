#include "deja_view/ros/map_directory.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxNameLength = 128;

// The name for an error message: what can't be printed is shown as '?'.
std::string Printable(const std::string& name) {
  std::string text = name.substr(0, kMaxNameLength);
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, '?');
  return text;
}

void CheckName(const std::string& name) {
  const auto is_forbidden = [](unsigned char c) {
    return c < 0x20 || c == 0x7F || c == '/' || c == '\\';
  };
  if (name.empty() || name.size() > kMaxNameLength || name.front() == '.' ||
      std::any_of(name.begin(), name.end(), is_forbidden)) {
    ThrowInputError(
        "map name '{}': expected 1 to {} bytes without '/', '\\' and control characters, not "
        "starting with '.'",
        Printable(name),
        kMaxNameLength);
  }
}

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
  CheckName(name);
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
