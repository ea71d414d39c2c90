#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace deja_view {

/// A parsed YAML document: the plain tree that the options reader walks.
struct ConfigNode {
  enum class Kind { kNull, kScalar, kList, kMap };

  Kind kind = Kind::kNull;
  int line = 0;            ///< first line is 1; 0: unknown
  bool is_quoted = false;  ///< a scalar in quotes is text, whatever it looks like
  std::string scalar;
  std::vector<ConfigNode> items;
  std::vector<std::pair<std::string, ConfigNode>> entries;  ///< in the order of the file
};

/// Parses a YAML file or text whose top level is a map (or empty). Throws InputError with the path
/// (or `name`) and line for bad syntax, a key that appears twice, or absurd size and depth.
ConfigNode ReadConfigFile(const std::filesystem::path& path);
ConfigNode ParseConfig(const std::string& text, const std::string& name);

/// Strict conversions of a scalar: nothing for text that is no such value, and for numbers in
/// quotes.
std::optional<bool> ToBool(const ConfigNode& node);  ///< true or false
std::optional<std::int64_t> ToInteger(const ConfigNode& node);
std::optional<double> ToNumber(const ConfigNode& node);  ///< also .inf, never NaN
std::optional<float> ToSingle(const ConfigNode& node);

/// "'text'" of a scalar, or "nothing", "a list", "a map".
std::string Describe(const ConfigNode& node);

/// The text in double quotes with YAML's escapes.
std::string QuoteYaml(const std::string& text);

/// The one of `known` with the smallest edit distance to `word`; empty when there is none.
std::string NearestWord(const std::string& word, const std::vector<std::string>& known);

}  // namespace deja_view
