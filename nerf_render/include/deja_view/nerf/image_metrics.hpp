#pragma once

#include "deja_view/features/brief_extractor.hpp"
#include "deja_view/nerf/training_view.hpp"

#include <opencv2/core/mat.hpp>

namespace deja_view::nerf {

/// Peak signal to noise ratio [dB] of two 8-bit images of the same size and type; 99 for equal
/// ones.
double Psnr(const cv::Mat& a, const cv::Mat& b);

/// Structural similarity (Wang et al., TIP 2004) of two CV_8U images of the same size, as grey
/// levels: Gaussian window of 11 px and sigma 1.5 px, mean over all places where it fits.
double Ssim(const cv::Mat& a, const cv::Mat& b);

/// Of the `corners` strongest FAST corners of `real` (CV_8UC1), the share whose BRIEF descriptor
/// has its nearest neighbour among the corners of `rendered` within `radius_px` of its own place
/// and at most `max_distance` - 1 bits away.
double CornerMatchRate(const cv::Mat& real,
                       const cv::Mat& rendered,
                       int corners = 1000,
                       double radius_px = 3,
                       int max_distance = 80);

/// What `camera` would see from T_N_C if every pixel's light came from image `from`, given the
/// ranges along its unit rays (`depth`, CV_32FC1 [m], 0: unknown); 0 where `from` does not see the
/// point. Against the real image it shows what any renderer can reach at best: noise, blur and
/// exposure of two photographs differ.
cv::Mat WarpImage(const TrainingView& from,
                  const Camera& camera,
                  const Rigid3& T_N_C,
                  const cv::Mat& depth);

}  // namespace deja_view::nerf
