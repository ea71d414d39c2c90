#include "deja_view/fusion/model_directory.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "safe_name.hpp"

namespace deja_view {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".dvn";

}  // namespace

ModelDirectory::ModelDirectory(fs::path root) : root_(std::move(root)) {}

fs::path ModelDirectory::Resolve(const std::string& name) const {
  internal::CheckName("model", name);
  std::error_code error;
  for (const std::string& file : {name, name + kExtension}) {
    fs::path path = root_ / file;
    const fs::file_status status = fs::symlink_status(path, error);
    if (fs::is_symlink(status)) {
      ThrowInputError("model '{}': {} is a link: expected a file of its own", name, path.string());
    }
    if (fs::is_regular_file(status)) {
      return path;
    }
  }
  ThrowInputError(
      "model '{}': no file in {}: expected one of {}", name, root_.string(), ListModels());
}

std::string ModelDirectory::ListModels() const {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(root_, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() == kExtension) {
      names.push_back(entry->path().stem().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names.empty() ? "no models at all" : fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace deja_view
