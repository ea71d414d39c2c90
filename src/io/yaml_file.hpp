#pragma once

#include <filesystem>
#include <string>

#include <yaml-cpp/yaml.h>

namespace deja_view::internal {

/// Parses a YAML file whose top level is a map (or empty). A first line `%YAML:1.0`, which OpenCV
/// writes and YAML itself forbids, is passed over. Throws InputError with the path and, for syntax,
/// the line.
YAML::Node LoadYamlMap(const std::filesystem::path& path);

/// As LoadYamlMap, from text; `name` stands for the path in errors.
YAML::Node ParseYamlMap(std::string text, const std::string& name);

/// "path:line" of a node, or the path alone where the node has no line of its own.
std::string Where(const std::string& path, const YAML::Mark& mark);

}  // namespace deja_view::internal
