#include "deja_view/base/check.hpp"
#include "deja_view/lab/report/html_report.hpp"
#include "deja_view/lab/report/plot.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <sstream>

#include "curves.hpp"
#include <fmt/format.h>

namespace deja_view::report {
namespace {

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
      {"Loops over time", "Accepted loops so far, per run.", "time [s]", "loops"}, curves, x, y);
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
  return DrawCurves({"Recall on thinner maps",
                     "Recall over the distance between the map's places.",
                     "distance between places [m]",
                     "recall"},
                    {curves.begin(), curves.end()},
                    x,
                    unit);
}

}  // namespace deja_view::report
