#pragma once

#include <filesystem>
#include <string>

namespace deja_view {

/// The directory in which a node keeps its maps, each in a directory of its own, known by name. A
/// name never leads out of it.
class MapDirectory {
 public:
  /// The directory need not exist yet.
  explicit MapDirectory(std::filesystem::path root);

  const std::filesystem::path& root() const { return root_; }

  /// Where the map `name` is, or would be. Throws InputError that names the name and what was
  /// expected when it is empty, longer than 128 bytes, starts with a dot, has a separator or a
  /// control character, or when what is there is a link or no directory.
  std::filesystem::path Resolve(const std::string& name) const;

  /// As Resolve, for a map that must be there; otherwise the error lists the maps that are.
  std::filesystem::path ResolveExisting(const std::string& name) const;

 private:
  std::string ListMaps() const;

  std::filesystem::path root_;
};

}  // namespace deja_view
