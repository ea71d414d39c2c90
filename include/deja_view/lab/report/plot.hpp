#pragma once

#include "deja_view/lab/report/svg.hpp"

#include <string>
#include <vector>

namespace deja_view::report {

/// An interval of numbers; empty until something is included.
struct Range {
  double min = 0;
  double max = 0;
  bool is_empty = true;

  /// Widens to hold `value`; passes over what is not finite.
  void Include(double value);
  void Include(const std::vector<double>& values);
  double size() const { return max - min; }
};

/// The step of the 1-2-5 series with which at most `at_most` + 1 multiples lie in the range.
double TickStep(const Range& range, int at_most);
/// The multiples of `step` in the range.
std::vector<double> Ticks(const Range& range, double step);
/// With as many decimals as the step needs: "0.05", "120".
std::string TickLabel(double value, double step);

/// A rectangle of a picture with the numbers that its sides stand for. Empty ranges and ranges of
/// no width are made one wide.
class Plot {
 public:
  Plot(const Point& corner, const Point& size, Range x, Range y);

  double left() const { return corner_.x(); }
  double right() const { return corner_.x() + size_.x(); }
  double top() const { return corner_.y(); }
  double bottom() const { return corner_.y() + size_.y(); }
  const Range& x() const { return x_; }
  const Range& y() const { return y_; }

  /// The place of a value; y grows upwards.
  Point ToPixel(double x, double y) const;
  std::vector<Point> ToPixels(const std::vector<double>& x, const std::vector<double>& y) const;

  /// Grid, axes, tick labels and the axes' names; an axis without a name has neither grid nor
  /// labels.
  void DrawAxes(const std::string& x_name, const std::string& y_name, Svg* svg) const;

 private:
  Point corner_;
  Point size_;
  Range x_;
  Range y_;
};

/// Width [px] of a text in the style sheet's plain type, roughly.
double TextWidth(std::string_view text);

}  // namespace deja_view::report
