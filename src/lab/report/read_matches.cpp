#include "deja_view/base/check.hpp"
#include "deja_view/lab/report/matches.hpp"

#include <algorithm>
#include <fstream>
#include <locale>
#include <sstream>

namespace deja_view::report {

std::vector<MatchedLoop> ReadMatches(const std::filesystem::path& path) {
  constexpr const char* kHeader =
      "stamp_current_ns,stamp_old_ns,virtual,view,u_old,v_old,u_current,v_current";
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line) || line != kHeader) {
    ThrowInputError("{}:1: expected a line {}", path.string(), kHeader);
  }
  std::vector<MatchedLoop> loops;
  for (int number = 2; std::getline(file, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream cells(line);
    cells.imbue(std::locale::classic());
    MatchedLoop loop;
    MatchedLoop::Pair pair;
    if (!(cells >> loop.stamp_current_ns >> loop.stamp_old_ns >> loop.is_virtual >> pair.view >>
          pair.old_pixel.x() >> pair.old_pixel.y() >> pair.current_pixel.x() >>
          pair.current_pixel.y())) {
      ThrowInputError("{}:{}: expected eight numbers", path.string(), number);
    }
    const bool is_new = loops.empty() || loops.back().stamp_current_ns != loop.stamp_current_ns ||
                        loops.back().stamp_old_ns != loop.stamp_old_ns;
    if (is_new) {
      loops.push_back(std::move(loop));
    }
    loops.back().pairs.push_back(pair);
  }
  return loops;
}

}  // namespace deja_view::report
