#include "deja_view/lab/report/plot.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace deja_view::report {
namespace {

Range AtLeastSomething(Range range) {
  if (range.is_empty) {
    return {0, 1, false};
  }
  if (range.size() <= 0) {
    return {range.min - 0.5, range.max + 0.5, false};
  }
  return range;
}

}  // namespace

void Range::Include(double value) {
  if (!std::isfinite(value)) {
    return;
  }
  min = is_empty ? value : std::min(min, value);
  max = is_empty ? value : std::max(max, value);
  is_empty = false;
}

void Range::Include(const std::vector<double>& values) {
  for (const double value : values) {
    Include(value);
  }
}

double TickStep(const Range& range, int at_most) {
  DEJA_VIEW_CHECK_OP(at_most, >=, 1);
  if (range.is_empty || range.size() <= 0) {
    return 1;
  }
  const double least = range.size() / at_most;
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least * (1 - 1e-9)) {
      return factor * power;
    }
  }
  return 10 * power;
}

std::vector<double> Ticks(const Range& range, double step) {
  std::vector<double> ticks;
  const double tolerance = 1e-9 * range.size();
  for (double k = std::ceil((range.min - tolerance) / step); k * step <= range.max + tolerance;
       ++k) {
    ticks.push_back(k * step);
  }
  return ticks;
}

std::string TickLabel(double value, double step) {
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  const std::string text = fmt::format("{:.{}f}", value, decimals);
  return std::stod(text) == 0 ? fmt::format("{:.{}f}", 0.0, decimals) : text;
}

Plot::Plot(const Point& corner, const Point& size, Range x, Range y)
    : corner_(corner), size_(size), x_(AtLeastSomething(x)), y_(AtLeastSomething(y)) {}

Point Plot::ToPixel(double x, double y) const {
  return {left() + (x - x_.min) / x_.size() * size_.x(),
          bottom() - (y - y_.min) / y_.size() * size_.y()};
}

std::vector<Point> Plot::ToPixels(const std::vector<double>& x,
                                  const std::vector<double>& y) const {
  DEJA_VIEW_CHECK_OP(x.size(), ==, y.size());
  std::vector<Point> pixels;
  for (std::size_t i = 0; i < x.size(); ++i) {
    pixels.push_back(ToPixel(x[i], y[i]));
  }
  return pixels;
}

void Plot::DrawAxes(const std::string& x_name, const std::string& y_name, Svg* svg) const {
  constexpr double kPixelsPerXTick = 90;
  constexpr double kPixelsPerYTick = 45;
  std::vector<std::pair<Point, Point>> grid;
  if (!x_name.empty()) {
    const double step = TickStep(x_, std::max(2, static_cast<int>(size_.x() / kPixelsPerXTick)));
    for (const double tick : Ticks(x_, step)) {
      const double x = ToPixel(tick, y_.min).x();
      grid.emplace_back(Point(x, top()), Point(x, bottom()));
      svg->AddText("small muted", {x, bottom() + 18}, TickLabel(tick, step), Anchor::kMiddle);
    }
    svg->AddText("small muted", {right(), bottom() + 36}, x_name, Anchor::kEnd);
  }
  if (!y_name.empty()) {
    const double step = TickStep(y_, std::max(2, static_cast<int>(size_.y() / kPixelsPerYTick)));
    for (const double tick : Ticks(y_, step)) {
      const double y = ToPixel(x_.min, tick).y();
      grid.emplace_back(Point(left(), y), Point(right(), y));
      svg->AddText("small muted", {left() - 8, y + 4}, TickLabel(tick, step), Anchor::kEnd);
    }
    svg->AddVerticalText("small muted", {left() - 46, 0.5 * (top() + bottom())}, y_name);
  }
  svg->AddSegments("grid", grid);
  svg->AddLine("axis", {left(), bottom()}, {right(), bottom()});
}

double TextWidth(std::string_view text) {
  constexpr double kPixelsPerCharacter = 7.1;
  const auto is_character = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; };
  return kPixelsPerCharacter *
         static_cast<double>(std::count_if(text.begin(), text.end(), is_character));
}

}  // namespace deja_view::report
