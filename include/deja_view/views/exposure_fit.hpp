#pragma once

#include <opencv2/core/mat.hpp>

namespace deja_view {

/// real = gain * rendered + bias, in units of white.
struct ExposureFit {
  double gain = 1;
  double bias = 0;
  double correlation = 0;  ///< of the two images, from -1 to 1
  double psnr_db = 0;      ///< of the fitted render
};

/// Least squares over the pixels of the smoothed images whose opacity is at least `min_opacity`,
/// repeated without those that are off by more than two standard deviations. The images are CV_8UC1
/// and the opacity CV_32FC1, of the same size. Keeps gain 1 and bias 0, with correlation 0, where
/// fewer than 100 pixels count or either image has no contrast.
ExposureFit FitExposure(const cv::Mat& rendered,
                        const cv::Mat& real,
                        const cv::Mat& opacity,
                        double min_opacity);

}  // namespace deja_view
