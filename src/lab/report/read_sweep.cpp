#include "deja_view/base/check.hpp"
#include "deja_view/lab/report/sweep.hpp"

#include <algorithm>
#include <fstream>
#include <functional>
#include <locale>
#include <sstream>

namespace deja_view::report {
namespace {

/// Calls `read` with the cells of every line below `head`; it returns false where they don't fit.
void ReadRows(const std::filesystem::path& path,
              const std::string& head,
              const std::function<bool(std::istream&)>& read) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line) || line != head) {
    ThrowInputError("{}:1: expected a line {}", path.string(), head);
  }
  for (int number = 2; std::getline(file, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream cells(line);
    cells.imbue(std::locale::classic());
    if (!read(cells)) {
      ThrowInputError("{}:{}: expected numbers for {}", path.string(), number, head);
    }
  }
}

}  // namespace

Sweep ReadSweep(const std::filesystem::path& directory) {
  Sweep sweep;
  sweep.name = directory.filename().string();
  ReadRows(directory / "sweep.csv", "r,found,correct,precision,recall", [&](std::istream& cells) {
    SweepPoint p;
    const bool ok =
        static_cast<bool>(cells >> p.r >> p.found >> p.correct >> p.precision >> p.recall);
    sweep.points.push_back(p);
    return ok;
  });
  const std::filesystem::path detections = directory / "detections.csv";
  if (std::filesystem::exists(detections)) {
    ReadRows(detections,
             "stamp_current_ns,stamp_old_ns,score,correct,revisit",
             [&](std::istream& cells) {
               Detection d;
               const bool ok = static_cast<bool>(cells >> d.stamp_current_ns >> d.stamp_old_ns >>
                                                 d.decision.score >> d.decision.is_correct >>
                                                 d.decision.is_revisit);
               sweep.detections.push_back(d);
               return ok;
             });
  }
  return sweep;
}

}  // namespace deja_view::report
