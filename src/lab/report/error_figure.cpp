#include "deja_view/base/check.hpp"
#include "deja_view/lab/report/figures.hpp"
#include "deja_view/lab/report/plot.hpp"

#include <set>

#include "axes.hpp"
#include "legend.hpp"
#include <fmt/format.h>

namespace deja_view::report {
namespace {

constexpr double kErrorHeight = 380;

struct ErrorCurve {
  std::string name;
  std::string css_class;
  const std::vector<double>& times_s;
  const std::vector<double>& errors;
  const std::optional<ApeStatistics>& ape;
};

std::vector<ErrorCurve> Curves(const std::vector<JudgedRun>& runs) {
  std::vector<ErrorCurve> curves;
  const JudgedRun& first = runs.front();
  curves.push_back({"odometry alone", "vio", first.times_s, first.vio_errors, first.vio_ape});
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::string name = runs.size() == 1 ? "with loops closed" : runs[i].run.name;
    curves.push_back({name,
                      fmt::format("run{}", i % 4),
                      runs[i].times_s,
                      runs[i].corrected_errors,
                      runs[i].corrected_ape});
  }
  return curves;
}

void DrawCurve(const ErrorCurve& curve, const Plot& plot, Svg* svg) {
  const std::vector<Point> points = plot.ToPixels(curve.times_s, curve.errors);
  svg->AddArea("area " + curve.css_class, points, plot.ToPixel(plot.x().min, 0).y());
  if (curve.ape) {
    svg->AddLine("mean " + curve.css_class,
                 plot.ToPixel(plot.x().min, curve.ape->mean),
                 plot.ToPixel(plot.x().max, curve.ape->mean));
  }
  svg->AddPolyline(curve.css_class, points);
}

/// A tick below the curves for every keyframe with an accepted loop.
void DrawLoopTicks(const JudgedRun& run, const Plot& plot, Svg* svg) {
  for (const bool wrong : {false, true}) {
    std::set<int> keyframes;
    for (std::size_t i = 0; i < run.run.loops.size(); ++i) {
      if (run.run.loops[i].accepted && run.ends[i].first >= 0 &&
          (run.verdicts[i] == Verdict::kWrong) == wrong) {
        keyframes.insert(run.ends[i].first);
      }
    }
    std::vector<std::pair<Point, Point>> ticks;
    for (const int keyframe : keyframes) {
      const double time = run.times_s[static_cast<std::size_t>(keyframe)];
      const double x = plot.ToPixel(time, 0).x();
      ticks.emplace_back(Point(x, plot.bottom() - 10), Point(x, plot.bottom() - 2));
    }
    svg->AddSegments(wrong ? "tick wrong" : "tick correct", ticks);
  }
}

}  // namespace

std::string ErrorFigure(const std::vector<JudgedRun>& runs) {
  DEJA_VIEW_CHECK(!runs.empty());
  const std::vector<ErrorCurve> curves = Curves(runs);
  Range times;
  Range errors;
  errors.Include(0);
  for (const ErrorCurve& curve : curves) {
    times.Include(curve.times_s);
    errors.Include(curve.errors);
  }
  const double largest = errors.max > 0 ? errors.max : 1.0;
  errors.Include(1.06 * largest);
  errors.Include(-0.06 * largest);  // a band for the loops
  Svg svg(
      kWidth,
      kErrorHeight,
      "Position error over time",
      "Distance to the true position per keyframe, after alignment, before and after loops were "
      "closed.");
  const Plot plot(
      {kLeft, kTop}, {kWidth - kLeft - kRight, kErrorHeight - kTop - kBottom}, times, errors);
  svg.AddText("title", {kLeft - 48, 30}, "Position error over time");
  Legend legend({kLeft - 48, 55}, &svg);
  plot.DrawAxes("time [s]", "error [m]", &svg);
  for (const ErrorCurve& curve : curves) {
    DrawCurve(curve, plot, &svg);
    legend.AddLine(
        curve.css_class,
        curve.ape ? fmt::format("{}, mean {:.3f} m", curve.name, curve.ape->mean) : curve.name);
  }
  DrawLoopTicks(runs.front(), plot, &svg);
  legend.AddLine("tick correct", "loops, at the time of their keyframe");
  return svg.ToString();
}

}  // namespace deja_view::report
