#pragma once

#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/core/version.hpp>

namespace deja_view::internal {

/// OpenCV's RANSAC; `mask` has a non-zero byte per inlier, and is empty where nothing was found.
/// Not USAC: it finds nothing where a plane or a mere shift explains all points, as they do when a
/// camera comes back to where it stood. OpenCV before 4.5 (Ubuntu 20.04 has 4.2) can't be told
/// `max_iterations`.
inline void FindFundamental(const std::vector<cv::Point2f>& a,
                            const std::vector<cv::Point2f>& b,
                            double max_error,
                            double confidence,
                            [[maybe_unused]] int max_iterations,
                            std::vector<unsigned char>* mask) {
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 5)
  cv::findFundamentalMat(a, b, cv::FM_RANSAC, max_error, confidence, max_iterations, *mask);
#else
  cv::findFundamentalMat(a, b, cv::FM_RANSAC, max_error, confidence, *mask);
#endif
}

/// The same for points on the plane at distance 1, errors on that plane.
inline void FindEssential(const std::vector<cv::Point2f>& a,
                          const std::vector<cv::Point2f>& b,
                          double max_error,
                          double confidence,
                          std::vector<unsigned char>* mask) {
  const cv::Mat identity = cv::Mat::eye(3, 3, CV_64F);
  cv::findEssentialMat(a, b, identity, cv::RANSAC, confidence, max_error, *mask);
}

}  // namespace deja_view::internal
