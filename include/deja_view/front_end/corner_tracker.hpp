#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace deja_view {

/// How corners are found and followed from image to image.
struct CornerTrackerOptions {
  int max_corners = 150;           ///< followed at a time
  double min_distance_px = 20;     ///< between them
  double min_quality = 0.01;       ///< of a corner, to the image's best (Shi and Tomasi, 1994)
  double refill_below = 0.85;      ///< share of max_corners: fewer, and new ones are looked for
  double max_round_trip_px = 0.5;  ///< of a corner followed to the next image and back

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("max_corners", max_corners);
    v("min_distance_px", min_distance_px);
    v("min_quality", min_quality);
    v("refill_below", refill_below);
    v("max_round_trip_px", max_round_trip_px);
  }
  std::vector<std::string> Validate() const;
};

/// The corners seen in one image: vectors of one length, ids ascending within a track's life.
struct TrackedCorners {
  std::vector<std::int64_t> ids;
  std::vector<cv::Point2f> pixels;
};

/// Follows corners from image to image by the pyramidal Lucas-Kanade flow, there and back; every
/// corner keeps its id for as long as it is followed. Deterministic. Not thread-safe.
class CornerTracker {
 public:
  /// Throws InputError for bad options.
  explicit CornerTracker(const CornerTrackerOptions& options);

  /// CV_8UC1; of the size of the one before. The result is valid until the next call.
  const TrackedCorners& Add(const cv::Mat& image);

  /// Where the newest image's corners are in another one of the same moment, by a second camera:
  /// one entry per corner, none for those that are not found there and back. CV_8UC1, of any size.
  std::vector<std::optional<cv::Point2f>> FindIn(const cv::Mat& image) const;

  /// Lets corners go that others have found wrong: those without a mark. One mark per corner of the
  /// newest image.
  void Keep(const std::vector<bool>& is_kept);

  /// Forgets the image and its corners; ids go on.
  void Restart();

 private:
  void Follow(const std::vector<cv::Mat>& pyramid);
  void Refill(const cv::Mat& image);

  CornerTrackerOptions options_;
  std::vector<cv::Mat> pyramid_;  ///< of the newest image; empty before the first
  TrackedCorners corners_;
  std::int64_t next_id_ = 0;
};

}  // namespace deja_view
