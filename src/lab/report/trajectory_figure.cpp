#include "deja_view/lab/report/figures.hpp"
#include "deja_view/lab/report/plot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axes.hpp"
#include "legend.hpp"
#include <fmt/format.h>

namespace deja_view::report {
namespace {

constexpr double kMargin = 28;
constexpr double kPanelGap = 32;
constexpr double kTitleHeight = 66;
constexpr double kLegendHeight = 52;
constexpr double kPanelWidth = (kWidth - 2 * kMargin - kPanelGap) / 2;
constexpr double kMaxPanelHeight = 560;
constexpr double kMinPanelHeight = 220;
constexpr double kPause = 2.0;  ///< [s] keyframes further apart are not joined by a line

/// One of the two maps.
struct Panel {
  std::string title;
  const std::vector<Eigen::Vector3d>& positions;
  const std::vector<double>& errors;
  const std::optional<ApeStatistics>& ape;
  std::string plain_class;  ///< where the truth is unknown
};

/// What both maps show: the same part of the world at the same scale.
struct View {
  Range x;
  Range y;
  double panel_height = 0;
};

View ChooseView(const JudgedRun& run) {
  Range x;
  Range y;
  for (const auto* positions : {&run.truth_path, &run.vio, &run.corrected}) {
    for (const Eigen::Vector3d& p : *positions) {
      x.Include(p.x());
      y.Include(p.y());
    }
  }
  constexpr double kPadding = 1.08;
  const double width = std::max(1e-3, x.size() * kPadding);
  const double height = std::max(1e-3, y.size() * kPadding);
  View view;
  view.panel_height = std::clamp(kPanelWidth * height / width, kMinPanelHeight, kMaxPanelHeight);
  const double meters_per_pixel = std::max(width / kPanelWidth, height / view.panel_height);
  const auto around = [&](const Range& range, double pixels) {
    const double middle = 0.5 * (range.min + range.max);
    const double half = 0.5 * pixels * meters_per_pixel;
    return Range{middle - half, middle + half, false};
  };
  view.x = around(x, kPanelWidth);
  view.y = around(y, view.panel_height);
  return view;
}

/// A round number that no error exceeds.
double ErrorScale(const JudgedRun& run) {
  Range errors;
  errors.Include(0);
  errors.Include(run.vio_errors);
  errors.Include(run.corrected_errors);
  const double step = TickStep(errors, 10);
  return std::max(step, step * std::ceil(errors.max / step - 1e-9));
}

/// Class of a piece of the way between two keyframes.
std::string ErrorClass(const Panel& panel, std::size_t from, double scale) {
  const double error = 0.5 * (panel.errors[from] + panel.errors[from + 1]);
  if (!std::isfinite(error)) {
    return panel.plain_class;
  }
  const int color = static_cast<int>(std::floor(kErrorColors * error / scale));
  return fmt::format("error e{}", std::clamp(color, 0, kErrorColors - 1));
}

void DrawGrid(const Plot& plot, Svg* svg) {
  const double step = TickStep(plot.x(), 8);
  std::vector<std::pair<Point, Point>> grid;
  for (const double tick : Ticks(plot.x(), step)) {
    const double x = plot.ToPixel(tick, 0).x();
    grid.emplace_back(Point(x, plot.top()), Point(x, plot.bottom()));
  }
  for (const double tick : Ticks(plot.y(), step)) {
    const double y = plot.ToPixel(0, tick).y();
    grid.emplace_back(Point(plot.left(), y), Point(plot.right(), y));
  }
  svg->AddSegments("grid", grid);
}

void DrawScaleBar(const Plot& plot, Svg* svg) {
  const double step = TickStep(plot.x(), 8);
  const double length = plot.ToPixel(step, 0).x() - plot.ToPixel(0, 0).x();
  const Point end(plot.right() - 4, plot.bottom() + 16);
  const Point start = end - Point(length, 0);
  svg->AddSegments("scale",
                   {{start, end},
                    {start - Point(0, 4), start + Point(0, 4)},
                    {end - Point(0, 4), end + Point(0, 4)}});
  svg->AddText("small muted", start + Point(-8, 4), TickLabel(step, step) + " m", Anchor::kEnd);
}

void DrawFlight(
    const JudgedRun& run, const Panel& panel, const Plot& plot, double scale, Svg* svg) {
  const auto pixel = [&](std::size_t i) {
    return plot.ToPixel(panel.positions[i].x(), panel.positions[i].y());
  };
  std::vector<Point> piece;
  std::string css_class;
  for (std::size_t i = 0; i + 1 < panel.positions.size(); ++i) {
    const bool is_pause = run.times_s[i + 1] - run.times_s[i] > kPause;
    const std::string next_class = is_pause ? "" : ErrorClass(panel, i, scale);
    if (next_class != css_class) {
      svg->AddPolyline(css_class, piece);
      piece.clear();
      css_class = next_class;
    }
    if (!is_pause) {
      if (piece.empty()) {
        piece.push_back(pixel(i));
      }
      piece.push_back(pixel(i + 1));
    }
  }
  svg->AddPolyline(css_class, piece);
}

void DrawLoops(const JudgedRun& run, const Plot& plot, bool wrong, Svg* svg) {
  std::vector<std::pair<Point, Point>> segments;
  for (std::size_t i = 0; i < run.run.loops.size(); ++i) {
    const auto [current, old] = run.ends[i];
    const bool is_wrong = run.verdicts[i] == Verdict::kWrong;
    if (run.run.loops[i].accepted && current >= 0 && old >= 0 && is_wrong == wrong) {
      const Eigen::Vector3d& from = run.corrected[static_cast<std::size_t>(current)];
      const Eigen::Vector3d& to = run.corrected[static_cast<std::size_t>(old)];
      segments.emplace_back(plot.ToPixel(from.x(), from.y()), plot.ToPixel(to.x(), to.y()));
    }
  }
  svg->AddSegments(wrong ? "run0 wrong" : "loop correct", segments);
}

void DrawPanel(const JudgedRun& run, const Panel& panel, const Plot& plot, double scale, Svg* svg) {
  svg->AddText("title", {plot.left(), plot.top() - 36}, panel.title);
  if (panel.ape) {
    svg->AddText(
        "muted",
        {plot.left(), plot.top() - 15},
        fmt::format("mean error {:.3f} m, largest {:.3f} m", panel.ape->mean, panel.ape->max));
  }
  DrawGrid(plot, svg);
  std::vector<Point> truth;
  for (const Eigen::Vector3d& p : run.truth_path) {
    truth.push_back(plot.ToPixel(p.x(), p.y()));
  }
  svg->AddPolyline("truth", truth);
  if (&panel.positions == &run.corrected) {
    DrawLoops(run, plot, false, svg);
  }
  DrawFlight(run, panel, plot, scale, svg);
  if (&panel.positions == &run.corrected) {
    DrawLoops(run, plot, true, svg);
  }
  if (!panel.positions.empty()) {
    const Eigen::Vector3d& start = panel.positions.front();
    const Point mark = plot.ToPixel(start.x(), start.y());
    svg->AddCircle("mark", mark, 4.5);
    svg->AddText("small halo", mark + Point(9, -9), "start");
  }
}

}  // namespace

std::string Count(int count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string TrajectoryFigure(const JudgedRun& run) {
  const View view = ChooseView(run);
  const double scale = ErrorScale(run);
  Svg svg(
      kWidth,
      kTitleHeight + view.panel_height + kLegendHeight,
      "The flight from above: " + run.run.name,
      "Left the trajectory of the odometry alone, right the one corrected by closed loops, both "
      "aligned with the true path and coloured by their distance to it.");
  const Panel panels[] = {
      {"Odometry alone", run.vio, run.vio_errors, run.vio_ape, "vio"},
      {"With loops closed", run.corrected, run.corrected_errors, run.corrected_ape, "run0"}};
  double left = kMargin;
  for (const Panel& panel : panels) {
    const Plot plot({left, kTitleHeight}, {kPanelWidth, view.panel_height}, view.x, view.y);
    DrawPanel(run, panel, plot, scale, &svg);
    left += kPanelWidth + kPanelGap;
    if (&panel == &panels[1]) {
      DrawScaleBar(plot, &svg);
    }
  }
  Legend legend({kMargin, kTitleHeight + view.panel_height + 32}, &svg);
  if (run.vio_ape) {
    legend.AddErrorScale(scale);
  }
  if (!run.truth_path.empty()) {
    legend.AddLine("truth", "true path");
  }
  const auto wrong = run.score ? run.score->judged - run.score->correct : 0;
  legend.AddLine("run0 correct", Count(run.AcceptedLoops() - wrong, "loop"));
  if (wrong > 0) {
    legend.AddLine("run0 wrong", Count(wrong, "wrong loop"));
  }
  return svg.ToString();
}

}  // namespace deja_view::report
