#include "deja_view/lab/report/figures.hpp"
#include "deja_view/lab/report/matches.hpp"

#include <algorithm>

#include "base64.hpp"
#include <fmt/format.h>

namespace deja_view::report {
namespace {

constexpr double kPanel = 530;  ///< width of an image
constexpr double kImageGap = 20;
constexpr double kImageTop = 34;
constexpr double kBetween = 30;  ///< rows; their captions are there

const Picture* Find(const Pictures& pictures, std::int64_t stamp_ns, int view) {
  const auto found = pictures.find({stamp_ns, view});
  return found == pictures.end() ? nullptr : &found->second;
}

/// Of an image without a picture, so that its points fit.
Picture Unknown(const MatchedLoop& loop) {
  Picture picture;
  picture.width = 752;
  picture.height = 480;
  for (const MatchedLoop::Pair& pair : loop.pairs) {
    for (const Point& pixel : {pair.old_pixel, pair.current_pixel}) {
      picture.width = std::max(picture.width, pixel.x());
      picture.height = std::max(picture.height, pixel.y());
    }
  }
  return picture;
}

/// An image at its place in the figure.
struct Panel {
  Picture picture;
  Point corner;

  double scale() const { return kPanel / picture.width; }
  double height() const { return scale() * picture.height; }
  Point At(const Point& pixel) const { return corner + scale() * (pixel + Point(0.5, 0.5)); }
  void Draw(Svg* svg) const {
    svg->AddRect("frame", corner, {kPanel, height()});
    if (!picture.jpeg.empty()) {
      svg->AddImage(corner, {kPanel, height()}, "data:image/jpeg;base64," + Base64(picture.jpeg));
    }
  }
};

struct ImageRow {
  int view = -1;
  Panel old;
  Panel current;
};

void DrawRow(const MatchedLoop& loop, const ImageRow& row, Svg* svg) {
  const std::string color = row.view < 0 ? "inlier" : "viewinlier";
  row.old.Draw(svg);
  row.current.Draw(svg);
  std::vector<std::pair<Point, Point>> lines;
  std::vector<Point> ends;
  for (const MatchedLoop::Pair& pair : loop.pairs) {
    if (pair.view == row.view) {
      lines.emplace_back(row.old.At(pair.old_pixel), row.current.At(pair.current_pixel));
      ends.insert(ends.end(), {lines.back().first, lines.back().second});
    }
  }
  svg->AddSegments("match " + color, lines);
  svg->AddDots("smalldot " + color, ends);
  const std::string what = row.view < 0 ? "the real image of the place"
                                        : fmt::format("virtual view {} of the place", row.view);
  svg->AddText("small muted",
               row.old.corner + Point(0, row.old.height() + 17),
               fmt::format("{}, {}", what, Count(static_cast<int>(lines.size()), loop.kind)));
  svg->AddText(
      "small muted", row.current.corner + Point(0, row.current.height() + 17), "the current image");
}

}  // namespace

int MatchedLoop::CountIn(int view) const {
  return static_cast<int>(std::count_if(
      pairs.begin(), pairs.end(), [view](const Pair& pair) { return pair.view == view; }));
}

int MatchedLoop::BestView() const {
  int best = -1;
  for (const Pair& pair : pairs) {
    if (pair.view >= 0 && (best < 0 || CountIn(pair.view) > CountIn(best))) {
      best = pair.view;
    }
  }
  return best;
}

std::vector<MatchedLoop> ChooseMatches(std::vector<MatchedLoop> loops, std::size_t at_most) {
  const auto with_views = [](const MatchedLoop& loop) { return loop.BestView() >= 0; };
  const auto middle = std::stable_partition(loops.begin(), loops.end(), with_views);
  std::vector<MatchedLoop> chosen;
  const auto take = [&](auto begin, auto end, std::size_t count) {
    const auto available = static_cast<std::size_t>(end - begin);
    count = std::min(count, available);
    for (std::size_t i = 0; i < count; ++i) {
      chosen.push_back(*(begin + static_cast<std::ptrdiff_t>(i * available / count)));
    }
  };
  // At least one of each kind where there are both.
  const bool has_real = middle != loops.end();
  take(loops.begin(), middle, at_most - (has_real ? std::min<std::size_t>(at_most, 1) : 0));
  take(middle, loops.end(), at_most - chosen.size());
  std::stable_sort(chosen.begin(), chosen.end(), [](const MatchedLoop& a, const MatchedLoop& b) {
    return a.stamp_current_ns < b.stamp_current_ns;
  });
  return chosen;
}

std::vector<std::pair<std::int64_t, int>> PicturesOf(const MatchedLoop& loop) {
  std::vector<std::pair<std::int64_t, int>> keys = {{loop.stamp_current_ns, -1},
                                                    {loop.stamp_old_ns, -1}};
  if (loop.BestView() >= 0) {
    keys.emplace_back(loop.stamp_old_ns, loop.BestView());
  }
  return keys;
}

std::string MatchTitle(const MatchedLoop& loop, std::int64_t start_ns) {
  const auto seconds = [start_ns](std::int64_t stamp_ns) {
    return stamp_ns < start_ns
               ? std::string("an earlier flight")
               : fmt::format("{:.1f} s", 1e-9 * static_cast<double>(stamp_ns - start_ns));
  };
  return fmt::format("At {} the place of {} is seen again: {}",
                     seconds(loop.stamp_current_ns),
                     seconds(loop.stamp_old_ns),
                     Count(static_cast<int>(loop.pairs.size()), "inlier")) +
         (loop.BestView() >= 0 ? " in the real image and the virtual views" : "");
}

std::string MatchFigure(const MatchedLoop& loop, const Pictures& pictures, std::int64_t start_ns) {
  return MatchFigure(loop, pictures, MatchTitle(loop, start_ns));
}

std::string MatchFigure(const MatchedLoop& loop,
                        const Pictures& pictures,
                        const std::string& title) {
  const auto panel = [&](std::int64_t stamp_ns, int view, double x, double y) {
    const Picture* picture = Find(pictures, stamp_ns, view);
    return Panel{picture != nullptr ? *picture : Unknown(loop), {x, y}};
  };
  std::vector<ImageRow> rows;
  double y = kImageTop;
  for (const int view : {-1, loop.BestView()}) {
    if (view < 0 && !rows.empty()) {
      break;
    }
    rows.push_back({view,
                    panel(loop.stamp_old_ns, view, 0, y),
                    panel(loop.stamp_current_ns, -1, kPanel + kImageGap, y)});
    y += std::max(rows.back().old.height(), rows.back().current.height()) + kBetween;
  }
  Svg svg(2 * kPanel + kImageGap,
          y,
          title,
          "Matched points joined by lines; the old image is on the left.");
  svg.AddText("title", {0, 20}, title);
  for (const ImageRow& row : rows) {
    DrawRow(loop, row, &svg);
  }
  return svg.ToString();
}

}  // namespace deja_view::report
