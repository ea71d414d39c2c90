#include "deja_view/nerf/image_metrics.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/features/hamming_matcher.hpp"

#include <cmath>

#include <opencv2/imgproc.hpp>

namespace deja_view::nerf {
namespace {

cv::Mat ToGreyFloat(const cv::Mat& image) {
  cv::Mat grey;
  if (image.channels() == 3) {
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  } else {
    grey = image;
  }
  cv::Mat result;
  grey.convertTo(result, CV_32F);
  return result;
}

cv::Mat Smooth(const cv::Mat& image) {
  cv::Mat result;
  cv::GaussianBlur(image, result, {11, 11}, 1.5);
  return result;
}

}  // namespace

double Psnr(const cv::Mat& a, const cv::Mat& b) {
  DEJA_VIEW_CHECK(a.size() == b.size() && a.type() == b.type() && a.depth() == CV_8U);
  const double error = cv::norm(a, b, cv::NORM_L2SQR) /
                       static_cast<double>(a.total() * static_cast<std::size_t>(a.channels()));
  return error > 0 ? 10 * std::log10(255.0 * 255.0 / error) : 99.0;
}

double Ssim(const cv::Mat& image_a, const cv::Mat& image_b) {
  DEJA_VIEW_CHECK(image_a.size() == image_b.size() && image_a.depth() == CV_8U);
  DEJA_VIEW_CHECK(image_a.cols >= 11 && image_a.rows >= 11);
  constexpr double kC1 = 0.01 * 255 * 0.01 * 255;
  constexpr double kC2 = 0.03 * 255 * 0.03 * 255;
  const cv::Mat a = ToGreyFloat(image_a);
  const cv::Mat b = ToGreyFloat(image_b);
  const cv::Mat mean_a = Smooth(a);
  const cv::Mat mean_b = Smooth(b);
  const cv::Mat var_a = Smooth(a.mul(a)) - mean_a.mul(mean_a);
  const cv::Mat var_b = Smooth(b.mul(b)) - mean_b.mul(mean_b);
  const cv::Mat covariance = Smooth(a.mul(b)) - mean_a.mul(mean_b);
  const cv::Mat above = (2 * mean_a.mul(mean_b) + kC1).mul(2 * covariance + kC2);
  const cv::Mat below = (mean_a.mul(mean_a) + mean_b.mul(mean_b) + kC1).mul(var_a + var_b + kC2);
  const cv::Mat ssim = above / below;
  return cv::mean(ssim(cv::Rect(5, 5, a.cols - 10, a.rows - 10)))[0];
}

double CornerMatchRate(
    const cv::Mat& real, const cv::Mat& rendered, int corners, double radius_px, int max_distance) {
  DEJA_VIEW_CHECK(real.size() == rendered.size());
  BriefOptions options;
  options.max_features = corners;
  options.cell_size_px = 0;
  const Features query = BriefExtractor(options).Extract(real);
  // A render may have weaker corners at the same places.
  options.max_features = 4 * corners;
  options.fast_threshold = 5;
  const Features train = BriefExtractor(options).Extract(rendered);
  const std::vector<HammingMatch> matches = MatchHamming(query.descriptors, train.descriptors);
  std::size_t found = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (matches[i].best < 0 || matches[i].best_distance >= max_distance) {
      continue;
    }
    const Keypoint& from = query.keypoints[i];
    const Keypoint& to = train.keypoints[static_cast<std::size_t>(matches[i].best)];
    const auto dx = static_cast<double>(from.x - to.x);
    const auto dy = static_cast<double>(from.y - to.y);
    found += std::hypot(dx, dy) <= radius_px ? 1U : 0U;
  }
  return query.keypoints.empty()
             ? 0.0
             : static_cast<double>(found) / static_cast<double>(query.keypoints.size());
}

cv::Mat WarpImage(const TrainingView& from,
                  const Camera& camera,
                  const Rigid3& T_N_C,
                  const cv::Mat& depth) {
  DEJA_VIEW_CHECK(depth.type() == CV_32FC1 && depth.cols == camera.width() &&
                  depth.rows == camera.height());
  const Rigid3 T_F_C = from.T_N_C.Inverse() * T_N_C;
  cv::Mat places(depth.size(), CV_32FC2, cv::Scalar(-1, -1));
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      const auto range = static_cast<double>(depth.at<float>(y, x));
      if (range <= 0) {
        continue;
      }
      const auto pixel = from.camera->Project(T_F_C * (range * camera.Unproject({x, y})));
      if (pixel && from.camera->IsInImage(*pixel)) {
        places.at<cv::Vec2f>(y, x) = {static_cast<float>(pixel->x()),
                                      static_cast<float>(pixel->y())};
      }
    }
  }
  cv::Mat result;
  cv::remap(from.image, result, places, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return result;
}

}  // namespace deja_view::nerf
