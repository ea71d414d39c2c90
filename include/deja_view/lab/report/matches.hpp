#pragma once

#include "deja_view/lab/report/run.hpp"
#include "deja_view/lab/report/svg.hpp"

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace deja_view::report {

/// An accepted loop with its inliers as pixels.
struct MatchedLoop {
  struct Pair {
    int view = -1;  ///< of the old keyframe's virtual views; -1: its real image
    Point old_pixel = Point::Zero();
    Point current_pixel = Point::Zero();
  };
  std::int64_t stamp_current_ns = 0;
  std::int64_t stamp_old_ns = 0;
  bool is_virtual = false;
  std::vector<Pair> pairs;
  std::string kind = "inlier";  ///< what a pair is called

  /// How many inliers are in the view.
  int CountIn(int view) const;
  /// The virtual view with most inliers, or -1 when no inlier is in any.
  int BestView() const;
};

/// Reads matches.csv, as replay and node leave it. Throws InputError that names file and line.
std::vector<MatchedLoop> ReadMatches(const std::filesystem::path& path);

/// A camera's image, real or virtual, as a JPEG that may be smaller than the camera's image.
struct Picture {
  std::string jpeg;  ///< bytes
  double width = 0;  ///< [px] of the camera's own image, in which pixels are told
  double height = 0;
};

/// Pictures by (stamp of the keyframe [ns], view; -1: the real image).
using Pictures = std::map<std::pair<std::int64_t, int>, Picture>;

/// Of the loops the `at_most` that show most: those with virtual views first, spread over the
/// flight, by time.
std::vector<MatchedLoop> ChooseMatches(std::vector<MatchedLoop> loops, std::size_t at_most);

/// (stamp, view) of all pictures that MatchFigure draws for the loop.
std::vector<std::pair<std::int64_t, int>> PicturesOf(const MatchedLoop& loop);

/// "At 62.5 s the place of 6.9 s is seen again: 81 inliers". `start_ns`: the flight's first
/// keyframe, from which times are counted.
std::string MatchTitle(const MatchedLoop& loop, std::int64_t start_ns);

/// The loop's images side by side, old on the left, with its inliers joined by lines: the real old
/// image, and where virtual views took part the one with most inliers. A picture that is missing is
/// drawn as an empty frame.
std::string MatchFigure(const MatchedLoop& loop, const Pictures& pictures, std::int64_t start_ns);
std::string MatchFigure(const MatchedLoop& loop,
                        const Pictures& pictures,
                        const std::string& title);

}  // namespace deja_view::report
