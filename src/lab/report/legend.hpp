#pragma once

#include "deja_view/lab/report/plot.hpp"

#include <string>

namespace deja_view::report {

/// Entries side by side, each a sample of a line or dot and its text.
class Legend {
 public:
  Legend(const Point& baseline, Svg* svg) : at_(baseline), svg_(svg) {}

  void AddLine(const std::string& css_class, const std::string& text);
  void AddDot(const std::string& css_class, const std::string& text);
  void AddBox(const std::string& css_class, const std::string& text);
  /// The colours of the error scale from 0 to `largest` [m].
  void AddErrorScale(double largest);

 private:
  void AddText(double sample_width, const std::string& text);

  Point at_;
  Svg* svg_;
};

}  // namespace deja_view::report
