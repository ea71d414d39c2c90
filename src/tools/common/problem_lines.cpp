#include "common/problem_lines.hpp"

#include <algorithm>
#include <cstddef>
#include <map>

#include <fmt/format.h>

namespace deja_view {
namespace {

/// `text` with a # for each stamp: nine digits or more in a row.
std::string WithoutStamps(const std::string& text) {
  constexpr std::ptrdiff_t kLeastDigits = 9;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::string result;
  for (auto it = text.begin(); it != text.end();) {
    const auto end = is_digit(*it) ? std::find_if_not(it, text.end(), is_digit) : it + 1;
    if (end - it >= kLeastDigits) {
      result += '#';
    } else {
      result.append(it, end);
    }
    it = end;
  }
  return result;
}

}  // namespace

std::vector<std::string> ProblemLines(const std::vector<std::string>& problems) {
  struct Kind {
    const std::string* first = nullptr;
    int count = 0;
  };
  std::map<std::string, std::size_t> index;
  std::vector<Kind> kinds;
  for (const std::string& problem : problems) {
    const auto [entry, is_new] = index.try_emplace(WithoutStamps(problem), kinds.size());
    if (is_new) {
      kinds.push_back({&problem, 0});
    }
    ++kinds[entry->second].count;
  }
  std::vector<std::string> lines;
  lines.reserve(kinds.size());
  for (const Kind& kind : kinds) {
    lines.push_back(kind.count > 1
                        ? fmt::format("{} (and {} more like it)", *kind.first, kind.count - 1)
                        : *kind.first);
  }
  return lines;
}

}  // namespace deja_view
