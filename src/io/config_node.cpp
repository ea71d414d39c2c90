#include "deja_view/io/config_node.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/quote.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <numeric>

#include "parse_number.hpp"
#include "yaml_file.hpp"

namespace deja_view {
namespace {

// Aliases can make a small file expand without end.
constexpr int kMaxDepth = 32;
constexpr int kMaxNodes = 100000;

class Converter {
 public:
  explicit Converter(std::string name) : name_(std::move(name)) {}

  // NOLINTNEXTLINE(misc-no-recursion): a document is a tree; kMaxDepth bounds it.
  ConfigNode Convert(const YAML::Node& node, int depth) {
    if (depth > kMaxDepth || ++count_ > kMaxNodes) {
      ThrowInputError(
          "{}: expected at most {} levels and {} values", Where(node), kMaxDepth, kMaxNodes);
    }
    ConfigNode result;
    result.line = node.Mark().is_null() ? 0 : node.Mark().line + 1;
    if (node.IsScalar()) {
      result.kind = ConfigNode::Kind::kScalar;
      result.scalar = node.Scalar();
      result.is_quoted = node.Tag() == "!";
    } else if (node.IsSequence()) {
      result.kind = ConfigNode::Kind::kList;
      for (const YAML::Node& item : node) {
        result.items.push_back(Convert(item, depth + 1));
      }
    } else if (node.IsMap()) {
      result.kind = ConfigNode::Kind::kMap;
      ConvertEntries(node, depth, &result);
    }
    return result;
  }

 private:
  // NOLINTNEXTLINE(misc-no-recursion): see Convert.
  void ConvertEntries(const YAML::Node& node, int depth, ConfigNode* result) {
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) {
        ThrowInputError("{}: expected a plain word as key", Where(entry.first));
      }
      const std::string& key = entry.first.Scalar();
      const bool is_repeated =
          std::any_of(result->entries.begin(), result->entries.end(), [&](const auto& earlier) {
            return earlier.first == key;
          });
      if (is_repeated) {
        ThrowInputError("{}: key {} appears twice", Where(entry.first), Quote(key));
      }
      ConfigNode child = Convert(entry.second, depth + 1);
      child.line = entry.first.Mark().is_null() ? child.line : entry.first.Mark().line + 1;
      result->entries.emplace_back(key, std::move(child));
    }
  }

  std::string Where(const YAML::Node& node) const { return internal::Where(name_, node.Mark()); }

  std::string name_;
  int count_ = 0;
};

template <typename T>
std::optional<T> ParseReal(const ConfigNode& node) {
  if (node.kind != ConfigNode::Kind::kScalar || node.is_quoted) {
    return std::nullopt;
  }
  if (node.scalar == ".inf" || node.scalar == "+.inf") {
    return std::numeric_limits<T>::infinity();
  }
  if (node.scalar == "-.inf") {
    return -std::numeric_limits<T>::infinity();
  }
  return internal::ParseNumber<T>(node.scalar);
}

}  // namespace

ConfigNode ReadConfigFile(const std::filesystem::path& path) {
  return Converter(path.string()).Convert(internal::LoadYamlMap(path), 0);
}

ConfigNode ParseConfig(const std::string& text, const std::string& name) {
  return Converter(name).Convert(internal::ParseYamlMap(text, name), 0);
}

std::optional<bool> ToBool(const ConfigNode& node) {
  if (node.kind != ConfigNode::Kind::kScalar || node.is_quoted ||
      (node.scalar != "true" && node.scalar != "false")) {
    return std::nullopt;
  }
  return node.scalar == "true";
}

std::optional<std::int64_t> ToInteger(const ConfigNode& node) {
  if (node.kind != ConfigNode::Kind::kScalar || node.is_quoted) {
    return std::nullopt;
  }
  const char* const end = node.scalar.data() + node.scalar.size();
  std::int64_t value = 0;
  const auto result = std::from_chars(node.scalar.data(), end, value);
  return result.ec == std::errc() && result.ptr == end ? std::make_optional(value) : std::nullopt;
}

std::optional<double> ToNumber(const ConfigNode& node) {
  return ParseReal<double>(node);
}

std::optional<float> ToSingle(const ConfigNode& node) {
  return ParseReal<float>(node);
}

std::string Describe(const ConfigNode& node) {
  switch (node.kind) {
    case ConfigNode::Kind::kNull:
      return "nothing";
    case ConfigNode::Kind::kList:
      return "a list";
    case ConfigNode::Kind::kMap:
      return "a map";
    case ConfigNode::Kind::kScalar:
      break;
  }
  return node.is_quoted ? "text " + Quote(node.scalar) : Quote(node.scalar);
}

std::string QuoteYaml(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      quoted += fmt::format("\\x{:02x}", static_cast<unsigned>(c));
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string NearestWord(const std::string& word, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t nearest_distance = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : known) {
    // Levenshtein's distance, one row at a time.
    std::vector<std::size_t> row(candidate.size() + 1);
    std::iota(row.begin(), row.end(), 0U);
    for (std::size_t i = 0; i < word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i + 1;
      for (std::size_t j = 0; j < candidate.size(); ++j) {
        const std::size_t substituted = diagonal + (word[i] == candidate[j] ? 0 : 1);
        diagonal = row[j + 1];
        row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
      }
    }
    if (row.back() < nearest_distance) {
      nearest_distance = row.back();
      nearest = candidate;
    }
  }
  return nearest;
}

}  // namespace deja_view
