#include "deja_view/base/check.hpp"
#include "deja_view/lab/report/html_report.hpp"
#include "deja_view/lab/report/plot.hpp"

#include <array>

#include "axes.hpp"
#include "legend.hpp"
#include <fmt/format.h>

namespace deja_view::report {
namespace {

constexpr double kApeHeight = 340;

struct Statistic {
  const char* name;
  double ApeStatistics::*value;
};

constexpr std::array<Statistic, 5> kStatistics = {{{"max", &ApeStatistics::max},
                                                   {"RMSE", &ApeStatistics::rmse},
                                                   {"mean", &ApeStatistics::mean},
                                                   {"median", &ApeStatistics::median},
                                                   {"min", &ApeStatistics::min}}};

struct Bars {
  std::string name;
  std::string css_class;
  ApeStatistics ape;
};

std::vector<Bars> Collect(const std::vector<JudgedRun>& runs) {
  std::vector<Bars> all;
  if (runs.front().vio_ape) {
    all.push_back({"odometry alone", "vio", *runs.front().vio_ape});
  }
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (runs[i].corrected_ape) {
      all.push_back({runs[i].run.name, fmt::format("run{}", i % 4), *runs[i].corrected_ape});
    }
  }
  return all;
}

}  // namespace

std::string ApeFigure(const std::vector<JudgedRun>& runs) {
  DEJA_VIEW_CHECK(!runs.empty());
  const std::vector<Bars> all = Collect(runs);
  if (all.empty()) {
    return {};
  }
  Range groups;
  groups.Include(0);
  groups.Include(static_cast<double>(kStatistics.size()));
  Range errors;
  errors.Include(0);
  for (const Bars& bars : all) {
    errors.Include(1.08 * bars.ape.max);
  }
  Svg svg(kWidth, kApeHeight, "Position errors", "Statistics of the position error, bars per run.");
  const Plot plot(
      {kLeft, kTop}, {kWidth - kLeft - kRight, kApeHeight - kTop - kBottom}, groups, errors);
  svg.AddText("title", {kLeft - 48, 30}, "Position errors");
  Legend legend({kLeft - 48, 55}, &svg);
  plot.DrawAxes("", "error [m]", &svg);
  const double width = 0.8 / static_cast<double>(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::vector<std::pair<Point, Point>> boxes;
    for (std::size_t k = 0; k < kStatistics.size(); ++k) {
      const double x = static_cast<double>(k) + 0.1 + width * static_cast<double>(i);
      const double value = all[i].ape.*kStatistics.at(k).value;
      boxes.emplace_back(plot.ToPixel(x, 0), plot.ToPixel(x + 0.9 * width, value));
    }
    svg.AddBoxes("bar " + all[i].css_class, boxes);
    legend.AddLine(all[i].css_class, all[i].name);
  }
  for (std::size_t k = 0; k < kStatistics.size(); ++k) {
    svg.AddText("small muted",
                plot.ToPixel(static_cast<double>(k) + 0.5, 0) + Point(0, 20),
                kStatistics.at(k).name,
                Anchor::kMiddle);
  }
  return svg.ToString();
}

}  // namespace deja_view::report
