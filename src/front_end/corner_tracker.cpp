#include "deja_view/front_end/corner_tracker.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <cstddef>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace deja_view {
namespace {

constexpr int kWindow = 21;   // [px]
constexpr int kLevels = 3;    // of the pyramid above the image
constexpr float kBorder = 1;  // [px] of the image where nothing is followed

const cv::TermCriteria kUntil(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.02);

using Pyramid = std::vector<cv::Mat>;

Pyramid MakePyramid(const cv::Mat& image) {
  DEJA_VIEW_CHECK(image.type() == CV_8UC1);
  Pyramid pyramid;
  cv::buildOpticalFlowPyramid(image, pyramid, {kWindow, kWindow}, kLevels);
  return pyramid;
}

/// Where pixels of an image are in another one; nothing for those that are not found there and, to
/// `max_round_trip_px`, back. Those of the image before are near; a second camera's may not be.
std::vector<std::optional<cv::Point2f>> FollowThereAndBack(const Pyramid& from,
                                                           const Pyramid& to,
                                                           const std::vector<cv::Point2f>& pixels,
                                                           double max_round_trip_px,
                                                           bool is_near) {
  std::vector<cv::Point2f> there;
  std::vector<cv::Point2f> back = pixels;
  std::vector<std::uint8_t> is_found;
  std::vector<std::uint8_t> is_found_back;
  std::vector<float> error;
  const cv::Size window(kWindow, kWindow);
  cv::calcOpticalFlowPyrLK(from, to, pixels, there, is_found, error, window, kLevels, kUntil);
  if (is_near) {
    // The way back starts from where it should end, so that the image alone is enough.
    cv::calcOpticalFlowPyrLK(to,
                             from,
                             there,
                             back,
                             is_found_back,
                             error,
                             window,
                             0,
                             kUntil,
                             cv::OPTFLOW_USE_INITIAL_FLOW);
  } else {
    cv::calcOpticalFlowPyrLK(to, from, there, back, is_found_back, error, window, kLevels, kUntil);
  }
  // The pyramid's images are parts of wider ones.
  const float right = static_cast<float>(to.front().cols - 1) - kBorder;
  const float bottom = static_cast<float>(to.front().rows - 1) - kBorder;
  std::vector<std::optional<cv::Point2f>> found(pixels.size());
  for (std::size_t i = 0; i < there.size(); ++i) {
    const cv::Point2f& p = there[i];
    if (is_found[i] != 0 && is_found_back[i] != 0 && p.x > kBorder && p.y > kBorder &&
        p.x < right && p.y < bottom && cv::norm(back[i] - pixels[i]) <= max_round_trip_px) {
      found[i] = p;
    }
  }
  return found;
}

}  // namespace

std::vector<std::string> CornerTrackerOptions::Validate() const {
  Requirements r;
  r.That(max_corners >= 10, "max_corners", max_corners, "at least 10");
  r.That(min_distance_px >= 1, "min_distance_px", min_distance_px, "at least 1 px");
  r.That(min_quality > 0 && min_quality < 1, "min_quality", min_quality, "between 0 and 1");
  r.Range("refill_below", refill_below, 0.0, 1.0);
  r.That(max_round_trip_px > 0, "max_round_trip_px", max_round_trip_px, "more than 0 px");
  return r.errors();
}

CornerTracker::CornerTracker(const CornerTrackerOptions& options) : options_(options) {
  CheckNone(options_.Validate(), "corner tracker options");
}

const TrackedCorners& CornerTracker::Add(const cv::Mat& image) {
  Pyramid pyramid = MakePyramid(image);
  if (!corners_.ids.empty()) {
    DEJA_VIEW_CHECK(pyramid.front().size() == pyramid_.front().size());
    Follow(pyramid);
  }
  if (static_cast<double>(corners_.ids.size()) < options_.refill_below * options_.max_corners) {
    Refill(image);
  }
  pyramid_ = std::move(pyramid);
  return corners_;
}

void CornerTracker::Follow(const std::vector<cv::Mat>& pyramid) {
  const auto found =
      FollowThereAndBack(pyramid_, pyramid, corners_.pixels, options_.max_round_trip_px, true);
  std::vector<bool> is_kept(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    is_kept[i] = found[i].has_value();
    corners_.pixels[i] = found[i].value_or(cv::Point2f());
  }
  Keep(is_kept);
}

std::vector<std::optional<cv::Point2f>> CornerTracker::FindIn(const cv::Mat& image) const {
  if (corners_.ids.empty()) {
    return {};
  }
  return FollowThereAndBack(
      pyramid_, MakePyramid(image), corners_.pixels, options_.max_round_trip_px, false);
}

void CornerTracker::Keep(const std::vector<bool>& is_kept) {
  DEJA_VIEW_CHECK(is_kept.size() == corners_.ids.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < is_kept.size(); ++i) {
    if (is_kept[i]) {
      corners_.ids[count] = corners_.ids[i];
      corners_.pixels[count] = corners_.pixels[i];
      ++count;
    }
  }
  corners_.ids.resize(count);
  corners_.pixels.resize(count);
}

// Of corners that have come close to each other the oldest stays.
void CornerTracker::Refill(const cv::Mat& image) {
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(255));
  std::vector<bool> is_kept(corners_.ids.size());
  for (std::size_t i = 0; i < is_kept.size(); ++i) {
    const cv::Point2i pixel(corners_.pixels[i]);
    is_kept[i] = mask.at<std::uint8_t>(pixel) != 0;
    if (is_kept[i]) {
      cv::circle(mask, pixel, cvRound(options_.min_distance_px), cv::Scalar(0), cv::FILLED);
    }
  }
  Keep(is_kept);
  const int missing = options_.max_corners - static_cast<int>(corners_.ids.size());
  if (missing <= 0) {
    return;
  }
  std::vector<cv::Point2f> fresh;
  cv::goodFeaturesToTrack(
      image, fresh, missing, options_.min_quality, options_.min_distance_px, mask);
  for (const cv::Point2f& pixel : fresh) {
    corners_.ids.push_back(next_id_++);
    corners_.pixels.push_back(pixel);
  }
}

void CornerTracker::Restart() {
  pyramid_.clear();
  corners_ = {};
}

}  // namespace deja_view
