#include "deja_view/lab/report/svg.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace deja_view::report {
namespace {

const char* AnchorName(Anchor anchor) {
  switch (anchor) {
    case Anchor::kMiddle:
      return "middle";
    case Anchor::kEnd:
      return "end";
    case Anchor::kStart:
      break;
  }
  return "start";
}

std::string Coordinates(const Point& p) {
  return FormatNumber(p.x()) + " " + FormatNumber(p.y());
}

double DistanceToSegment(const Point& p, const Point& from, const Point& to) {
  const Point along = to - from;
  const double length2 = along.squaredNorm();
  const double u = length2 > 0 ? std::clamp((p - from).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - from - u * along).norm();
}

/// The fewest points whose line stays within `tolerance` of all (Douglas and Peucker, 1973).
std::vector<Point> Simplify(const std::vector<Point>& points, double tolerance) {
  std::vector<bool> is_kept(points.size(), false);
  is_kept.front() = is_kept.back() = true;
  std::vector<std::pair<std::size_t, std::size_t>> open = {{0, points.size() - 1}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    double largest = tolerance;
    std::size_t farthest = first;
    for (std::size_t i = first + 1; i < last; ++i) {
      const double distance = DistanceToSegment(points[i], points[first], points[last]);
      if (distance > largest) {
        largest = distance;
        farthest = i;
      }
    }
    if (farthest != first) {
      is_kept[farthest] = true;
      open.emplace_back(first, farthest);
      open.emplace_back(farthest, last);
    }
  }
  std::vector<Point> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_kept[i]) {
      kept.push_back(points[i]);
    }
  }
  return kept;
}

/// Pieces of a line between its gaps, simplified.
std::vector<std::vector<Point>> Pieces(const std::vector<Point>& points) {
  constexpr double kTolerance = 0.1;
  std::vector<std::vector<Point>> pieces;
  std::vector<Point> piece;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].allFinite()) {
      piece.push_back(points[i]);
    }
    if (!piece.empty() && (i + 1 == points.size() || !points[i].allFinite())) {
      pieces.push_back(Simplify(piece, kTolerance));
      piece.clear();
    }
  }
  return pieces;
}

std::string LineData(const std::vector<Point>& piece) {
  std::string data;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    data += (i == 0 ? "M" : "L") + Coordinates(piece[i]);
  }
  return data;
}

}  // namespace

std::string EscapeXml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&apos;";
        break;
      default: {
        const auto byte = static_cast<unsigned char>(c);
        const bool is_forbidden = byte < 0x20 && c != '\t' && c != '\n' && c != '\r';
        escaped += is_forbidden ? std::string("\xEF\xBF\xBD") : std::string(1, c);
      }
    }
  }
  return escaped;
}

std::string FormatNumber(double value) {
  DEJA_VIEW_CHECK(std::isfinite(value));
  std::string text = fmt::format("{:.2f}", value);
  while (text.back() == '0') {
    text.pop_back();
  }
  if (text.back() == '.') {
    text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

Svg::Svg(double width, double height, std::string_view title, std::string_view description)
    : width_(width), height_(height) {
  head_ = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\" role=\"img\">\n<title>{2}</title>\n<desc>{3}</desc>\n",
      FormatNumber(width),
      FormatNumber(height),
      EscapeXml(title),
      EscapeXml(description));
  AddRect("page", Point(0, 0), Point(width, height));
}

void Svg::AddRect(std::string_view css_class,
                  const Point& corner,
                  const Point& size,
                  double radius) {
  if (!corner.allFinite() || !size.allFinite()) {
    return;
  }
  body_ += fmt::format("<rect class=\"{}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"",
                       EscapeXml(css_class),
                       FormatNumber(corner.x()),
                       FormatNumber(corner.y()),
                       FormatNumber(size.x()),
                       FormatNumber(size.y()));
  body_ += radius > 0 ? fmt::format(" rx=\"{}\"/>\n", FormatNumber(radius)) : "/>\n";
}

void Svg::AddLine(std::string_view css_class, const Point& from, const Point& to) {
  AddSegments(css_class, {{from, to}});
}

void Svg::AddPolyline(std::string_view css_class, const std::vector<Point>& points) {
  std::string data;
  for (const std::vector<Point>& piece : Pieces(points)) {
    data += LineData(piece);
  }
  AddPath(css_class, data);
}

void Svg::AddArea(std::string_view css_class, const std::vector<Point>& points, double base_y) {
  std::string data;
  for (const std::vector<Point>& piece : Pieces(points)) {
    data +=
        LineData(piece) + "V" + FormatNumber(base_y) + "H" + FormatNumber(piece.front().x()) + "Z";
  }
  AddPath(css_class, data);
}

void Svg::AddSegments(std::string_view css_class,
                      const std::vector<std::pair<Point, Point>>& segments) {
  std::string data;
  for (const auto& [from, to] : segments) {
    if (from.allFinite() && to.allFinite()) {
      data += "M" + Coordinates(from) + "L" + Coordinates(to);
    }
  }
  AddPath(css_class, data);
}

void Svg::AddBoxes(std::string_view css_class,
                   const std::vector<std::pair<Point, Point>>& corners) {
  std::string data;
  for (const auto& [from, to] : corners) {
    if (from.allFinite() && to.allFinite()) {
      data += "M" + Coordinates(from) + "H" + FormatNumber(to.x()) + "V" + FormatNumber(to.y()) +
              "H" + FormatNumber(from.x()) + "Z";
    }
  }
  AddPath(css_class, data);
}

void Svg::AddDots(std::string_view css_class, const std::vector<Point>& centers) {
  std::string data;
  for (const Point& center : centers) {
    if (center.allFinite()) {
      data += "M" + Coordinates(center) + "h0";
    }
  }
  AddPath(css_class, data);
}

void Svg::AddImage(const Point& corner, const Point& size, std::string_view address) {
  if (corner.allFinite() && size.allFinite()) {
    body_ += fmt::format("<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" href=\"{}\"/>\n",
                         FormatNumber(corner.x()),
                         FormatNumber(corner.y()),
                         FormatNumber(size.x()),
                         FormatNumber(size.y()),
                         EscapeXml(address));
  }
}

void Svg::AddCircle(std::string_view css_class, const Point& center, double radius) {
  if (center.allFinite()) {
    body_ += fmt::format("<circle class=\"{}\" cx=\"{}\" cy=\"{}\" r=\"{}\"/>\n",
                         EscapeXml(css_class),
                         FormatNumber(center.x()),
                         FormatNumber(center.y()),
                         FormatNumber(radius));
  }
}

void Svg::AddText(std::string_view css_class,
                  const Point& baseline,
                  std::string_view text,
                  Anchor anchor) {
  if (baseline.allFinite()) {
    body_ += fmt::format("<text class=\"{}\" x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>\n",
                         EscapeXml(css_class),
                         FormatNumber(baseline.x()),
                         FormatNumber(baseline.y()),
                         AnchorName(anchor),
                         EscapeXml(text));
  }
}

void Svg::AddVerticalText(std::string_view css_class, const Point& center, std::string_view text) {
  if (center.allFinite()) {
    body_ += fmt::format(
        "<text class=\"{}\" transform=\"translate({}) rotate(-90)\" "
        "text-anchor=\"middle\">{}</text>\n",
        EscapeXml(css_class),
        Coordinates(center),
        EscapeXml(text));
  }
}

void Svg::AddPath(std::string_view css_class, const std::string& data) {
  if (!data.empty()) {
    body_ += fmt::format("<path class=\"{}\" d=\"{}\"/>\n", EscapeXml(css_class), data);
  }
}

std::string Svg::ToString() const {
  return head_ + "<style>\n" + StyleSheet() + "</style>\n" + body_ + "</svg>\n";
}

}  // namespace deja_view::report
