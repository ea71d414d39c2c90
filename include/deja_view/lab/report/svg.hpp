#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace deja_view::report {

/// A place in a picture [px]: x to the right, y down.
using Point = Eigen::Vector2d;

/// Text that is safe inside XML elements and attribute values. Bytes that XML 1.0 forbids (control
/// characters) become U+FFFD.
std::string EscapeXml(std::string_view text);

/// Two decimals at most, without trailing zeros: "1.5", "0", "-3.25". Throws CheckError for a
/// number that is not finite, which no XML viewer could read.
std::string FormatNumber(double value);

enum class Anchor { kStart, kMiddle, kEnd };

/// An SVG picture, built element by element; later elements cover earlier ones.
///
/// Elements are styled by class alone (see StyleSheet), so that one picture suits light and dark
/// pages. Points that are not finite leave a gap in lines and are left out elsewhere.
class Svg {
 public:
  /// `title` and `description` are for screen readers and tooltips.
  Svg(double width, double height, std::string_view title, std::string_view description);

  double width() const { return width_; }
  double height() const { return height_; }

  void AddRect(std::string_view css_class,
               const Point& corner,
               const Point& size,
               double radius = 0);
  void AddLine(std::string_view css_class, const Point& from, const Point& to);
  /// A line through the points, of which those are left out that change it by less than a tenth of
  /// a pixel.
  void AddPolyline(std::string_view css_class, const std::vector<Point>& points);
  /// The area between the points and the horizontal line at `base_y`.
  void AddArea(std::string_view css_class, const std::vector<Point>& points, double base_y);
  void AddSegments(std::string_view css_class,
                   const std::vector<std::pair<Point, Point>>& segments);
  /// Filled boxes, each given by two opposite corners.
  void AddBoxes(std::string_view css_class, const std::vector<std::pair<Point, Point>>& corners);
  /// Dots as wide as the class's line, which needs round caps.
  void AddDots(std::string_view css_class, const std::vector<Point>& centers);
  /// An image at the given place; `address` is a data: address.
  void AddImage(const Point& corner, const Point& size, std::string_view address);
  void AddCircle(std::string_view css_class, const Point& center, double radius);
  void AddText(std::string_view css_class,
               const Point& baseline,
               std::string_view text,
               Anchor anchor = Anchor::kStart);
  /// Text that reads upwards, centred at `center`.
  void AddVerticalText(std::string_view css_class, const Point& center, std::string_view text);

  /// The whole document.
  std::string ToString() const;

 private:
  void AddPath(std::string_view css_class, const std::string& data);

  double width_;
  double height_;
  std::string head_;
  std::string body_;
};

/// The colours of the error scale, from none to the largest: CSS classes e0, e1, ...
constexpr int kErrorColors = 16;

/// CSS of all classes, for light pages and, by a media query, for dark ones.
const std::string& StyleSheet();

}  // namespace deja_view::report
