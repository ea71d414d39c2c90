#pragma once

#include <filesystem>
#include <string>

namespace deja_view {

/// The directory in which a node finds its models, files known by name. A name never leads out of
/// it.
class ModelDirectory {
 public:
  explicit ModelDirectory(std::filesystem::path root);

  /// The file `name`, or `name`.dvn. Throws InputError that names the name and what was expected
  /// when it is empty, longer than 128 bytes, starts with a dot, has a separator or a control
  /// character, when what is there is a link or no file, or when there is none; it then lists those
  /// that are.
  std::filesystem::path Resolve(const std::string& name) const;

 private:
  std::string ListModels() const;

  std::filesystem::path root_;
};

}  // namespace deja_view
