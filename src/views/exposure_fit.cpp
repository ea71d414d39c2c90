#include "deja_view/views/exposure_fit.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

struct Pair {
  double rendered = 0;  // grey levels
  double real = 0;
};

struct Sums {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;

  void Add(const Pair& p) {
    n += 1;
    x += p.rendered;
    y += p.real;
    xx += p.rendered * p.rendered;
    xy += p.rendered * p.real;
    yy += p.real * p.real;
  }
  double VarianceX() const { return xx / n - x / n * x / n; }
  double VarianceY() const { return yy / n - y / n * y / n; }
  double Covariance() const { return xy / n - x / n * y / n; }
};

constexpr double kMinPixels = 100;
constexpr int kRounds = 6;
constexpr double kMinVariance = 1;  // grey levels squared

Sums SumOf(const std::vector<Pair>& pairs, double gain, double bias, double limit) {
  Sums sums;
  for (const Pair& pair : pairs) {
    if (std::abs(pair.real - gain * pair.rendered - bias) <= limit) {
      sums.Add(pair);
    }
  }
  return sums;
}

cv::Mat Smooth(const cv::Mat& image) {
  cv::Mat smooth;
  cv::GaussianBlur(image, smooth, {0, 0}, 2);
  return smooth;
}

std::vector<Pair> MakePairs(const cv::Mat& rendered,
                            const cv::Mat& real,
                            const cv::Mat& opacity,
                            double min_opacity) {
  std::vector<Pair> pairs;
  for (int y = 0; y < real.rows; ++y) {
    for (int x = 0; x < real.cols; ++x) {
      if (opacity.at<float>(y, x) >= static_cast<float>(min_opacity)) {
        pairs.push_back({static_cast<double>(rendered.at<std::uint8_t>(y, x)),
                         static_cast<double>(real.at<std::uint8_t>(y, x))});
      }
    }
  }
  return pairs;
}

}  // namespace

ExposureFit FitExposure(const cv::Mat& rendered,
                        const cv::Mat& real,
                        const cv::Mat& opacity,
                        double min_opacity) {
  DEJA_VIEW_CHECK(rendered.type() == CV_8UC1 && real.type() == CV_8UC1);
  DEJA_VIEW_CHECK(rendered.size() == real.size() && rendered.size() == opacity.size());
  // Detail that only one of the two shows, aliased or blurred, would make the gain too small.
  const std::vector<Pair> smooth = MakePairs(Smooth(rendered), Smooth(real), opacity, min_opacity);
  const Sums all = SumOf(smooth, 0, 0, 1e9);
  if (all.n < kMinPixels || all.VarianceX() < kMinVariance || all.VarianceY() < kMinVariance) {
    return {};
  }
  ExposureFit fit;
  fit.correlation = all.Covariance() / std::sqrt(all.VarianceX() * all.VarianceY());
  double bias = 0;
  Sums inner = all;
  for (int i = 0; i < kRounds; ++i) {
    fit.gain = inner.Covariance() / inner.VarianceX();
    bias = (inner.y - fit.gain * inner.x) / inner.n;
    const double variance = inner.VarianceY() - fit.gain * inner.Covariance();
    const Sums next =
        SumOf(smooth, fit.gain, bias, 2 * std::sqrt(std::max(variance, kMinVariance)));
    if (next.n < kMinPixels || next.VarianceX() < kMinVariance) {
      break;
    }
    inner = next;
  }
  double error = 0;
  for (const Pair& pair : MakePairs(rendered, real, opacity, min_opacity)) {
    error += std::pow(pair.real - fit.gain * pair.rendered - bias, 2);
  }
  fit.psnr_db = 10 * std::log10(255.0 * 255.0 * all.n / std::max(error, 1e-9));
  fit.bias = bias / 255;
  return fit;
}

}  // namespace deja_view
