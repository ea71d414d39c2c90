#pragma once

#include <filesystem>
#include <string>

#include <yaml-cpp/yaml.h>

namespace deja_view::internal {

/// Parses a YAML file whose top level is a map (or empty). A first line `%YAML:1.0`, which OpenCV
/// writes and YAML itself forbids, is passed over. Throws InputError with the path and, for syntax,
/// the line.
YAML::Node LoadYamlMap(const std::filesystem::path& path);

/// "path:line" of a node, or the path alone where the node has no line of its own.
std::string Where(const std::filesystem::path& path, const YAML::Mark& mark);

}  // namespace deja_view::internal
