#include "deja_view/base/check.hpp"
#include "deja_view/report/html_report.hpp"
#include "deja_view/report/plot.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <sstream>

#include "legend.hpp"
#include <fmt/format.h>

namespace deja_view::report {
namespace {

constexpr double kWidth = 1080;
constexpr double kHeight = 400;
constexpr double kLeft = 76;
constexpr double kTop = 78;
constexpr double kRight = 28;
constexpr double kBottom = 50;
constexpr std::size_t kMostCurves = 4;  ///< that have a colour of their own

const Point kCorner(kLeft, kTop);
const Point kSize(kWidth - kLeft - kRight, kHeight - kTop - kBottom);

std::string ClassOf(std::size_t curve) {
  return fmt::format("run{}", curve % kMostCurves);
}

struct Curve {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
  std::string css_class;  ///< empty: the next colour
};

std::string DrawCurves(const std::string& title,
                       const std::string& description,
                       const std::string& x_name,
                       const std::string& y_name,
                       const std::vector<Curve>& curves,
                       Range x,
                       Range y) {
  Svg svg(kWidth, kHeight, title, description);
  const Plot plot(kCorner, kSize, x, y);
  svg.AddText("title", {kLeft - 48, 30}, title);
  Legend legend({kLeft - 48, 55}, &svg);
  plot.DrawAxes(x_name, y_name, &svg);
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const std::string css_class = curves[i].css_class.empty() ? ClassOf(i) : curves[i].css_class;
    svg.AddPolyline(css_class, plot.ToPixels(curves[i].x, curves[i].y));
    legend.AddLine(css_class, curves[i].name);
  }
  return svg.ToString();
}

Curve CountOf(const JudgedRun& run) {
  std::map<double, int> at;  // accepted loops by the time of their keyframe
  for (std::size_t i = 0; i < run.run.loops.size(); ++i) {
    if (run.run.loops[i].accepted && run.ends[i].first >= 0) {
      ++at[run.times_s[static_cast<std::size_t>(run.ends[i].first)]];
    }
  }
  Curve curve;
  int count = 0;
  curve.x.push_back(0);
  curve.y.push_back(0);
  for (const auto& [time, loops] : at) {
    curve.x.insert(curve.x.end(), {time, time});
    curve.y.push_back(count);
    count += loops;
    curve.y.push_back(count);
  }
  if (!run.times_s.empty()) {
    curve.x.push_back(run.times_s.back());
    curve.y.push_back(count);
  }
  curve.name = fmt::format("{}, {}", run.run.name, count);
  return curve;
}

}  // namespace

Sweep ReadSweep(const std::filesystem::path& path, const std::string& name) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line) || line != "r,found,correct,precision,recall") {
    ThrowInputError("{}:1: expected a line r,found,correct,precision,recall", path.string());
  }
  Sweep sweep;
  sweep.name = name;
  for (int number = 2; std::getline(file, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream cells(line);
    cells.imbue(std::locale::classic());
    double r = 0, found = 0, correct = 0, precision = 0, recall = 0;
    if (!(cells >> r >> found >> correct >> precision >> recall)) {
      ThrowInputError("{}:{}: expected five numbers", path.string(), number);
    }
    sweep.r.push_back(r);
    sweep.found.push_back(found);
    sweep.correct.push_back(correct);
    sweep.precision.push_back(precision);
    sweep.recall.push_back(recall);
  }
  return sweep;
}

std::string LoopCountFigure(const std::vector<JudgedRun>& runs) {
  DEJA_VIEW_CHECK(!runs.empty());
  std::vector<Curve> curves;
  Range x;
  Range y;
  y.Include(0);
  y.Include(1);
  for (std::size_t i = 0; i < std::min(runs.size(), kMostCurves); ++i) {
    curves.push_back(CountOf(runs[i]));
    x.Include(curves.back().x);
    y.Include(curves.back().y);
  }
  return DrawCurves(
      "Loops over time", "Accepted loops so far, per run.", "time [s]", "loops", curves, x, y);
}

std::string SweepFigure(const std::vector<Sweep>& sweeps) {
  std::vector<Curve> curves;
  Range unit;
  unit.Include(0);
  unit.Include(1);
  for (std::size_t i = 0; i < std::min(sweeps.size(), kMostCurves); ++i) {
    curves.push_back({sweeps[i].name, sweeps[i].recall, sweeps[i].precision, {}});
  }
  return DrawCurves("Places told by score alone",
                    "Precision over recall as the threshold r falls, per way of scoring; geometry "
                    "is not looked at.",
                    "recall",
                    "precision",
                    curves,
                    unit,
                    unit);
}

std::string ThresholdFigure(const std::vector<Sweep>& sweeps) {
  std::vector<Curve> curves;
  Range r;
  Range counts;
  counts.Include(0);
  for (std::size_t i = 0; i < std::min(sweeps.size(), kMostCurves); ++i) {
    const Sweep& sweep = sweeps[i];
    curves.push_back({sweep.name + ", found", sweep.r, sweep.found, ClassOf(i)});
    curves.push_back({"correct", sweep.r, sweep.correct, ClassOf(i) + " dashed"});
    r.Include(sweep.r);
    counts.Include(sweep.found);
  }
  return DrawCurves("The threshold r",
                    "Places found by score alone, and the correct ones of them, over the "
                    "threshold r.",
                    "r",
                    "keyframes",
                    curves,
                    r,
                    counts);
}

std::string SpacingFigure(const nlohmann::ordered_json& variants) {
  std::array<Curve, 2> curves = {Curve{"without virtual views", {}, {}, {}},
                                 Curve{"with virtual views", {}, {}, {}}};
  Range x;
  x.Include(0);
  for (const auto& entry : variants) {
    const std::string name = entry.at("name").get<std::string>();
    double spacing = 0;
    std::istringstream stream(name.substr(std::min<std::size_t>(8, name.size())));
    if (name.rfind("spacing_", 0) != 0 || !(stream >> spacing)) {
      continue;
    }
    const bool is_map = entry.contains("map_recall") && entry["map_recall"].is_number();
    const auto& recall = entry.at(is_map ? "map_recall" : "recall");
    if (recall.is_number()) {
      Curve& curve = curves.at(name.find("_no_virtual") == std::string::npos ? 1 : 0);
      curve.x.push_back(spacing);
      curve.y.push_back(recall.get<double>());
      x.Include(spacing);
    }
  }
  if (curves[0].x.empty() && curves[1].x.empty()) {
    return {};
  }
  Range unit;
  unit.Include(0);
  unit.Include(1);
  return DrawCurves("Recall on thinner maps",
                    "Recall over the distance between the map's places.",
                    "distance between places [m]",
                    "recall",
                    {curves.begin(), curves.end()},
                    x,
                    unit);
}

}  // namespace deja_view::report
