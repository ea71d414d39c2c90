#include "common/problem_lines.hpp"

#include <map>
#include <regex>

#include <fmt/format.h>

namespace deja_view {

std::vector<std::string> ProblemLines(const std::vector<std::string>& problems) {
  static const std::regex kStamp("[0-9]{9,}");
  struct Kind {
    const std::string* first = nullptr;
    int count = 0;
  };
  std::map<std::string, std::size_t> index;
  std::vector<Kind> kinds;
  for (const std::string& problem : problems) {
    const auto [entry, is_new] =
        index.try_emplace(std::regex_replace(problem, kStamp, "#"), kinds.size());
    if (is_new) {
      kinds.push_back({&problem, 0});
    }
    ++kinds[entry->second].count;
  }
  std::vector<std::string> lines;
  for (const Kind& kind : kinds) {
    lines.push_back(kind.count > 1
                        ? fmt::format("{} (and {} more like it)", *kind.first, kind.count - 1)
                        : *kind.first);
  }
  return lines;
}

}  // namespace deja_view
