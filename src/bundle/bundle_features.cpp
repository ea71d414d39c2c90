#include "deja_view/bundle/bundle_features.hpp"

#include "deja_view/features/keypoint_grid.hpp"

#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

/// Corners at whole pixels to where the gradients about them meet.
void RefineCorners(const cv::Mat& grey, std::vector<cv::Point2f>* corners) {
  if (corners->empty()) {
    return;
  }
  constexpr int kHalfWindowPx = 3;
  // FAST sees a right angle up to 2 px inside of it; farther is another corner.
  constexpr float kMaxShiftPx = 2.5F;
  const std::vector<cv::Point2f> found = *corners;
  cv::cornerSubPix(grey,
                   *corners,
                   {kHalfWindowPx, kHalfWindowPx},
                   {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 10, 0.02});
  for (std::size_t i = 0; i < found.size(); ++i) {
    const cv::Point2f shift = (*corners)[i] - found[i];
    if (!(shift.dot(shift) < kMaxShiftPx * kMaxShiftPx)) {
      (*corners)[i] = found[i];
    }
  }
}

}  // namespace

void DescribeImage(const cv::Mat& grey,
                   const std::vector<BundleTrackedPixel>& tracked,
                   const FeatureExtractor& extractor,
                   BundleImage* image) {
  constexpr float kApartPx = 4;
  constexpr float kCellPx = 16;
  std::vector<cv::Point2f> pixels;
  image->keypoints.clear();
  image->track_ids.clear();
  for (const BundleTrackedPixel& t : tracked) {
    pixels.emplace_back(t.pixel.x(), t.pixel.y());
    image->keypoints.push_back(t.pixel);
    image->track_ids.push_back(t.track_id);
  }
  Features features = extractor.Extract(grey, {}, pixels, &image->descriptors);
  const std::vector<Eigen::Vector2f> taken = image->keypoints;
  const KeypointGrid grid(taken, grey.cols, grey.rows, kCellPx);
  std::vector<cv::Point2f> corners;
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    const Eigen::Vector2f pixel(features.keypoints[i].x, features.keypoints[i].y);
    bool is_taken = false;
    grid.ForEachNear(pixel, kApartPx, [&](int) { is_taken = true; });
    if (!is_taken) {
      corners.emplace_back(pixel.x(), pixel.y());
      image->descriptors.push_back(features.descriptors[i]);
    }
  }
  RefineCorners(grey, &corners);
  for (const cv::Point2f& corner : corners) {
    image->keypoints.emplace_back(corner.x, corner.y);
    image->track_ids.push_back(-1);
  }
}

}  // namespace deja_view
