#pragma once

#include "deja_view/lab/report/plot.hpp"

#include <string>
#include <vector>

#include "axes.hpp"

namespace deja_view::report {

constexpr double kCurveHeight = 400;  ///< [px] of a figure

constexpr std::size_t kMostCurves = 4;  ///< that have a colour of their own

/// The class of a figure's i-th curve.
std::string CurveClass(std::size_t i);

struct Curve {
  std::string name;  ///< empty: not in the legend
  std::vector<double> x;
  std::vector<double> y;
  std::string css_class;  ///< empty: the next colour
};

struct CurveFigure {
  std::string title;
  std::string description;
  std::string x_name;
  std::string y_name;
};

std::string DrawCurves(const CurveFigure& figure,
                       const std::vector<Curve>& curves,
                       const Range& x,
                       const Range& y);

}  // namespace deja_view::report
