#include "curves.hpp"

#include "legend.hpp"
#include <fmt/format.h>

namespace deja_view::report {

std::string CurveClass(std::size_t i) {
  return fmt::format("run{}", i % kMostCurves);
}

std::string DrawCurves(const CurveFigure& figure,
                       const std::vector<Curve>& curves,
                       const Range& x,
                       const Range& y) {
  Svg svg(kWidth, kCurveHeight, figure.title, figure.description);
  const Plot plot({kLeft, kTop}, {kWidth - kLeft - kRight, kCurveHeight - kTop - kBottom}, x, y);
  svg.AddText("title", {kLeft - 48, 30}, figure.title);
  Legend legend({kLeft - 48, 55}, &svg);
  plot.DrawAxes(figure.x_name, figure.y_name, &svg);
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const std::string css_class = curves[i].css_class.empty() ? CurveClass(i) : curves[i].css_class;
    svg.AddPolyline(css_class, plot.ToPixels(curves[i].x, curves[i].y));
    if (!curves[i].name.empty()) {
      legend.AddLine(css_class, curves[i].name);
    }
  }
  return svg.ToString();
}

}  // namespace deja_view::report
