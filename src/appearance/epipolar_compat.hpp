#pragma once

#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/version.hpp>

#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 5)
#define DEJA_VIEW_HAVE_USAC
#endif

namespace deja_view::internal {

/// USAC refuses what a plane or a mere shift explains, as when a camera comes back to where it
/// stood: fewer inliers than that, and plain RANSAC is asked.
inline bool HasInliers(const std::vector<unsigned char>& mask) {
  constexpr int kFewest = 8;
  return !mask.empty() && cv::countNonZero(mask) >= kFewest;
}

/// Inliers of a fundamental matrix: `mask` has a non-zero byte per inlier, and is empty where
/// nothing was found. USAC (OpenCV from 4.5 on) is several times as fast as RANSAC. OpenCV before
/// (Ubuntu 20.04 has 4.2) can't be told `max_iterations`.
inline void FindFundamental(const std::vector<cv::Point2f>& a,
                            const std::vector<cv::Point2f>& b,
                            double max_error,
                            double confidence,
                            [[maybe_unused]] int max_iterations,
                            std::vector<unsigned char>* mask) {
#ifdef DEJA_VIEW_HAVE_USAC
  cv::findFundamentalMat(a, b, cv::USAC_DEFAULT, max_error, confidence, max_iterations, *mask);
  if (!HasInliers(*mask)) {
    cv::findFundamentalMat(a, b, cv::FM_RANSAC, max_error, confidence, max_iterations, *mask);
  }
#else
  cv::findFundamentalMat(a, b, cv::FM_RANSAC, max_error, confidence, *mask);
#endif
}

/// The same of an essential matrix, for points on the plane at distance 1, errors on that plane.
/// RANSAC for five points takes too long where little agrees: eight are asked instead.
inline void FindEssential(const std::vector<cv::Point2f>& a,
                          const std::vector<cv::Point2f>& b,
                          double max_error,
                          double confidence,
                          [[maybe_unused]] int max_iterations,
                          std::vector<unsigned char>* mask) {
  const cv::Mat identity = cv::Mat::eye(3, 3, CV_64F);
#ifdef DEJA_VIEW_HAVE_USAC
  cv::findEssentialMat(a, b, identity, cv::USAC_DEFAULT, confidence, max_error, *mask);
  if (!HasInliers(*mask)) {
    cv::findFundamentalMat(a, b, cv::FM_RANSAC, max_error, confidence, max_iterations, *mask);
  }
#else
  cv::findEssentialMat(a, b, identity, cv::RANSAC, confidence, max_error, *mask);
#endif
}

}  // namespace deja_view::internal
