#include "deja_view/base/check.hpp"
#include "deja_view/lab/report/html_report.hpp"
#include "deja_view/lab/report/plot.hpp"

#include <array>
#include <set>

#include "axes.hpp"
#include "legend.hpp"
#include <fmt/format.h>

namespace deja_view::report {
namespace {

constexpr double kTableLeft = 28;
constexpr double kTableTop = 74;
constexpr double kRow = 46;  ///< a run's, with its name above the ticks
constexpr double kTick = 20;

/// Times [s] of the keyframes with an accepted loop.
std::set<double> Detections(const JudgedRun& run) {
  std::set<double> times;
  for (std::size_t i = 0; i < run.run.loops.size(); ++i) {
    if (run.run.loops[i].accepted && run.ends[i].first >= 0) {
      times.insert(run.times_s[static_cast<std::size_t>(run.ends[i].first)]);
    }
  }
  return times;
}

using Segments = std::vector<std::pair<Point, Point>>;

/// Draws one run's row; returns how many keyframes it has that `before` has not.
int DrawRow(const std::set<double>& times,
            const std::set<double>* before,
            const Plot& plot,
            double y,
            Svg* svg) {
  std::array<Segments, 2> ticks;
  for (const double time : times) {
    const bool is_further = before != nullptr && before->count(time) == 0;
    const double x = plot.ToPixel(time, 0).x();
    ticks.at(is_further ? 1 : 0).emplace_back(Point(x, y), Point(x, y + kTick));
  }
  svg->AddSegments("detection run0", ticks[0]);
  svg->AddSegments("detection run3", ticks[1]);
  return static_cast<int>(ticks[1].size());
}

}  // namespace

std::string DetectionFigure(const std::vector<JudgedRun>& runs) {
  DEJA_VIEW_CHECK(!runs.empty());
  Range times;
  for (const JudgedRun& run : runs) {
    times.Include(run.times_s);
  }
  const double rows = kRow * static_cast<double>(runs.size());
  Svg svg(kWidth,
          kTableTop + rows + kBottom,
          "Keyframes with a loop",
          "A tick per keyframe for which a loop was detected, a row per run.");
  Range unit;
  unit.Include(0);
  unit.Include(1);
  const Plot plot({kTableLeft, kTableTop}, {kWidth - 2 * kTableLeft, rows}, times, unit);
  svg.AddText("title", {kTableLeft, 30}, "Keyframes with a loop");
  Legend legend({kTableLeft, 55}, &svg);
  legend.AddLine("run0", "as in the run before");
  legend.AddLine("run3", "further ones");
  plot.DrawAxes("time [s]", "", &svg);
  std::set<double> before;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::set<double> found = Detections(runs[i]);
    const double y = kTableTop + kRow * static_cast<double>(i);
    const int further = DrawRow(found, i == 0 ? nullptr : &before, plot, y + kRow - kTick, &svg);
    std::string text = fmt::format("{}, {}", runs[i].run.name, found.size());
    text += i == 0 ? "" : fmt::format(", {} further", further);
    svg.AddText("small halo", {kTableLeft, y + kRow - kTick - 6}, text);
    before = found;
  }
  return svg.ToString();
}

}  // namespace deja_view::report
