#include "deja_view/lab/report/plot.hpp"
#include "deja_view/lab/report/sweep.hpp"

#include <algorithm>
#include <cmath>

#include "curves.hpp"
#include "legend.hpp"
#include <fmt/format.h>

namespace deja_view::report {
namespace {

constexpr double kScores = 640;  ///< width of the scores over time
constexpr double kPlotGap = 34;

Range Unit() {
  return {0, 1, false};
}

enum class Kind { kCorrect, kWrong, kNothing };

Kind KindOf(const ScoredDecision& decision) {
  return decision.is_correct ? Kind::kCorrect : decision.is_revisit ? Kind::kWrong : Kind::kNothing;
}

/// The scores of one kind over time; `start_ns` is at 0 s.
std::vector<Point> Dots(const Sweep& sweep, Kind kind, std::int64_t start_ns, const Plot& plot) {
  std::vector<Point> dots;
  for (const Detection& d : sweep.detections) {
    if (KindOf(d.decision) == kind) {
      dots.push_back(plot.ToPixel(1e-9 * static_cast<double>(d.stamp_current_ns - start_ns),
                                  d.decision.score));
    }
  }
  return dots;
}

void DrawScores(const Sweep& sweep, std::int64_t start_ns, const Plot& plot, Svg* svg) {
  Legend legend({kLeft - 48, 55}, svg);
  struct Class {
    Kind kind;
    const char* css_class;
    const char* name;
  };
  constexpr Class kClasses[] = {{Kind::kNothing, "smalldot refused", "nothing to be found"},
                                {Kind::kWrong, "smalldot wrong", "wrong place"},
                                {Kind::kCorrect, "smalldot correct", "right place"}};
  for (const Class& c : kClasses) {
    svg->AddDots(c.css_class, Dots(sweep, c.kind, start_ns, plot));
    legend.AddDot(c.css_class, c.name);
  }
}

void DrawRates(const Sweep& sweep, const Plot& plot, Svg* svg) {
  std::vector<Point> precision;
  std::vector<Point> recall;
  for (const SweepPoint& p : sweep.points) {
    precision.push_back(plot.ToPixel(p.precision, p.r));
    recall.push_back(plot.ToPixel(p.recall, p.r));
  }
  svg->AddPolyline("run0", precision);
  svg->AddPolyline("run3", recall);
  Legend legend({plot.left(), 55}, svg);
  legend.AddLine("run0", "precision");
  legend.AddLine("run3", "recall");
}

std::string Chosen(const SweepPoint& point) {
  return point.found == 0
             ? std::string("no r has precision 1")
             : fmt::format("r = {:.3f} for precision 1, recall {:.3f}", point.r, point.recall);
}

}  // namespace

std::string ScoreFigure(const Sweep& sweep) {
  Range times;
  Range scores;
  scores.Include(0);
  const std::int64_t start_ns =
      sweep.detections.empty() ? 0 : sweep.detections.front().stamp_current_ns;
  for (const Detection& d : sweep.detections) {
    times.Include(1e-9 * static_cast<double>(d.stamp_current_ns - start_ns));
    scores.Include(1.04 * d.decision.score);
  }
  const std::string title = "Scores: " + sweep.name;
  Svg svg(kWidth,
          kCurveHeight,
          title,
          "The best score of every keyframe over time, and precision and recall of a threshold "
          "at that score.");
  const double height = kCurveHeight - kTop - kBottom;
  const Plot left({kLeft, kTop}, {kScores, height}, times, scores);
  const double begin = kLeft + kScores + kPlotGap;
  const Plot right({begin, kTop}, {kWidth - begin - kRight, height}, Unit(), scores);
  const SweepPoint chosen = PickThreshold(sweep.points, 1.0);
  svg.AddText("title", {kLeft - 48, 30}, title + "; " + Chosen(chosen));
  left.DrawAxes("time since the first score [s]", "score", &svg);
  right.DrawAxes("share", "", &svg);
  DrawScores(sweep, start_ns, left, &svg);
  DrawRates(sweep, right, &svg);
  if (chosen.found > 0) {
    svg.AddLine("mean scale", left.ToPixel(left.x().min, chosen.r), right.ToPixel(1, chosen.r));
  }
  return svg.ToString();
}

std::string SweepFigure(const std::vector<Sweep>& sweeps) {
  std::vector<Curve> curves;
  for (std::size_t i = 0; i < std::min(sweeps.size(), kMostCurves); ++i) {
    Curve curve{sweeps[i].name, {}, {}, {}};
    for (const SweepPoint& p : sweeps[i].points) {
      curve.x.push_back(p.recall);
      curve.y.push_back(p.precision);
    }
    curves.push_back(std::move(curve));
  }
  return DrawCurves({"Places told by score alone",
                     "Precision over recall as the threshold r falls, per way of scoring; geometry "
                     "is not looked at.",
                     "recall",
                     "precision"},
                    curves,
                    Unit(),
                    Unit());
}

std::string ThresholdFigure(const std::vector<Sweep>& sweeps) {
  std::vector<Curve> curves;
  Range r;
  Range counts;
  counts.Include(0);
  for (std::size_t i = 0; i < std::min(sweeps.size(), kMostCurves); ++i) {
    Curve found{sweeps[i].name, {}, {}, CurveClass(i)};
    Curve correct{{}, {}, {}, CurveClass(i) + " dashed"};
    for (const SweepPoint& p : sweeps[i].points) {
      found.x.push_back(p.r);
      found.y.push_back(p.found);
      correct.y.push_back(p.correct);
    }
    correct.x = found.x;
    r.Include(found.x);
    counts.Include(found.y);
    curves.push_back(std::move(found));
    curves.push_back(std::move(correct));
  }
  return DrawCurves({"Places found over the threshold r; dashed: the correct ones",
                     "Places found by score alone, and the correct ones of them, over the "
                     "threshold r.",
                     "r",
                     "keyframes"},
                    curves,
                    r,
                    counts);
}

std::vector<std::vector<std::string>> ThresholdRows(const std::vector<Sweep>& sweeps) {
  std::vector<std::vector<std::string>> rows = {{"scores", "r", "precision", "recall", "found"}};
  for (const Sweep& sweep : sweeps) {
    for (const double precision : {1.0, 0.99}) {
      const SweepPoint p = PickThreshold(sweep.points, precision);
      if (p.found > 0) {
        rows.push_back({sweep.name,
                        fmt::format("{:.3f}", p.r),
                        fmt::format("{:.4f}", p.precision),
                        fmt::format("{:.3f}", p.recall),
                        std::to_string(p.found)});
      } else {
        rows.push_back(
            {sweep.name, "–", fmt::format("{:g} is never reached", precision), "–", "–"});
      }
    }
  }
  return rows;
}

}  // namespace deja_view::report
