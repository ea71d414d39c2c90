#include "deja_view/lab/report/figures.hpp"
#include "deja_view/lab/report/plot.hpp"

#include <algorithm>

#include "axes.hpp"
#include "legend.hpp"
#include <fmt/format.h>

namespace deja_view::report {
namespace {

constexpr double kLoopHeight = 560;

/// Half of the time to the neighbouring keyframes: where a keyframe's cell begins and ends.
Range Cell(const std::vector<double>& times_s, std::size_t i) {
  constexpr double kWidest = 0.5;  ///< [s]
  const double before = i > 0 ? times_s[i] - times_s[i - 1] : 0;
  const double after = i + 1 < times_s.size() ? times_s[i + 1] - times_s[i] : 0;
  return {times_s[i] - std::min(0.5 * before, kWidest),
          times_s[i] + std::min(0.5 * after, kWidest),
          false};
}

/// Boxes where the truth says "same place", one per keyframe and unbroken run of old keyframes.
void DrawRevisits(const JudgedRun& run, const Plot& plot, Svg* svg) {
  std::vector<std::pair<Point, Point>> boxes;
  for (std::size_t i = 0; i < run.revisits.size();) {
    std::size_t end = i + 1;
    while (end < run.revisits.size() && run.revisits[end].first == run.revisits[i].first &&
           run.revisits[end].second == run.revisits[end - 1].second + 1) {
      ++end;
    }
    const Range x = Cell(run.times_s, static_cast<std::size_t>(run.revisits[i].first));
    const Range from = Cell(run.times_s, static_cast<std::size_t>(run.revisits[i].second));
    const Range to = Cell(run.times_s, static_cast<std::size_t>(run.revisits[end - 1].second));
    boxes.emplace_back(plot.ToPixel(x.min, from.min), plot.ToPixel(x.max, to.max));
    i = end;
  }
  svg->AddBoxes("revisit", boxes);
}

/// Places of the candidates that `select` picks by index.
template <typename Select>
std::vector<Point> Dots(const JudgedRun& run, const Plot& plot, const Select& select) {
  std::vector<Point> dots;
  for (std::size_t i = 0; i < run.run.loops.size(); ++i) {
    const auto [current, old] = run.ends[i];
    if (current >= 0 && old >= 0 && select(i)) {
      dots.push_back(plot.ToPixel(run.times_s[static_cast<std::size_t>(current)],
                                  run.times_s[static_cast<std::size_t>(old)]));
    }
  }
  return dots;
}

std::string Summary(const JudgedRun& run) {
  std::string text = Count(run.AcceptedLoops(), "loop");
  if (run.score) {
    text += fmt::format(", precision {:.3f}", run.score->precision());
  }
  if (run.HasRecall()) {
    text += fmt::format(", recall {:.3f}", run.score->recall());
  }
  return text;
}

}  // namespace

std::string LoopFigure(const JudgedRun& run) {
  Range times;
  times.Include(run.times_s);
  Svg svg(kWidth,
          kLoopHeight,
          "Loops: " + run.run.name,
          "Every verified loop candidate by the time of its keyframe and of the keyframe it was "
          "matched with; shaded where both saw the same place.");
  const Plot plot(
      {kLeft, kTop}, {kWidth - kLeft - kRight, kLoopHeight - kTop - kBottom}, times, times);
  const auto is = [&run](bool accepted, bool wrong) {
    return [&run, accepted, wrong](std::size_t i) {
      const bool is_wrong = run.verdicts[i] == Verdict::kWrong;
      return run.run.loops[i].accepted == accepted && (!accepted || is_wrong == wrong);
    };
  };
  svg.AddText("title", {kLeft - 48, 30}, Summary(run));
  plot.DrawAxes("time of the keyframe [s]", "time of the place it was matched with [s]", &svg);
  DrawRevisits(run, plot, &svg);
  svg.AddDots("smalldot refused", Dots(run, plot, is(false, false)));
  svg.AddDots("dot correct", Dots(run, plot, is(true, false)));
  svg.AddDots("dot wrong", Dots(run, plot, is(true, true)));
  Legend legend({kLeft - 48, 55}, &svg);
  legend.AddDot("dot correct", run.score ? "correct loop" : "loop");
  if (run.score) {
    legend.AddDot("dot wrong", "wrong loop");
  }
  legend.AddDot("smalldot refused", "refused candidate");
  if (run.has_camera && run.score) {
    legend.AddBox("revisit", "same place, says the ground truth");
  }
  return svg.ToString();
}

}  // namespace deja_view::report
