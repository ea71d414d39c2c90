#include "deja_view/io/options_yaml.hpp"

#include "deja_view/base/quote.hpp"

#include <algorithm>

namespace deja_view::internal {
namespace {

std::string At(const std::string& file, int line) {
  return line > 0 ? fmt::format("{}:{}", file, line) : file;
}

}  // namespace

void OptionsReader::Report(const ConfigNode& node,
                           const std::string& key,
                           const std::string& expected) {
  errors_->push_back(fmt::format(
      "{}: key '{}': expected {}, found {}", At(file_, node.line), key, expected, Describe(node)));
}

void OptionsReader::ReportUnknownKeys() const {
  for (const auto& [key, node] : map_.entries) {
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) {
      continue;
    }
    const std::string nearest = NearestWord(key, known_);
    errors_->push_back(fmt::format(
        "{}: unknown key {}{}",
        At(file_, node.line),
        Quote(prefix_ + key),
        nearest.empty() ? "" : fmt::format("; did you mean '{}{}'?", prefix_, nearest)));
  }
}

void ThrowIfAny(const std::vector<std::string>& errors) {
  constexpr std::size_t kMaxTold = 20;  // another kind of file has nothing but errors
  if (errors.size() > kMaxTold) {
    throw InputError(fmt::format("{}\n... and {} more",
                                 fmt::join(errors.begin(), errors.begin() + kMaxTold, "\n"),
                                 errors.size() - kMaxTold));
  }
  if (!errors.empty()) {
    throw InputError(fmt::format("{}", fmt::join(errors, "\n")));
  }
}

ConfigNode ParseOverride(const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    ThrowInputError("{}: expected key=value", Quote(assignment));
  }
  const std::string value = assignment.substr(equals + 1);
  // "value: x" keeps YAML's own rules for the right-hand side: numbers, quotes, [lists].
  ConfigNode node = ParseConfig("value: " + value, Quote(assignment));
  if (node.entries.size() != 1) {
    ThrowInputError("{}: expected key=value", Quote(assignment));
  }
  node = std::move(node.entries.front().second);
  node.line = 0;
  std::string path = assignment.substr(0, equals);
  for (bool is_root = false; !is_root;) {
    const std::size_t dot = path.rfind('.');
    is_root = dot == std::string::npos;
    ConfigNode parent;
    parent.kind = ConfigNode::Kind::kMap;
    parent.entries.emplace_back(path.substr(is_root ? 0 : dot + 1), std::move(node));
    node = std::move(parent);
    path.resize(is_root ? 0 : dot);
  }
  return node;
}

}  // namespace deja_view::internal
