#pragma once

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace deja_view::test {

/// Grey rectangles and discs on a gradient with some noise: corners of all strengths, more of them
/// on the left.
inline cv::Mat SyntheticImage(int width, int height, std::uint64_t seed) {
  cv::RNG rng(seed);
  cv::Mat image(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(60 + 80 * x / width + 40 * y / height);
    }
  }
  for (int i = 0; i < width * height / 400; ++i) {
    const double u = rng.uniform(0.0, 1.0);
    const int x = static_cast<int>(u * u * width);
    const int y = rng.uniform(0, height);
    const cv::Scalar grey(rng.uniform(0, 256));
    if (i % 3 == 0) {
      cv::circle(image, {x, y}, rng.uniform(2, 12), grey, cv::FILLED);
    } else {
      cv::rectangle(
          image, cv::Rect(x, y, rng.uniform(3, 30), rng.uniform(3, 30)), grey, cv::FILLED);
    }
  }
  cv::Mat noise(height, width, CV_16SC1);
  rng.fill(noise, cv::RNG::NORMAL, 0, 2);
  cv::Mat sum;
  image.convertTo(sum, CV_16SC1);
  sum += noise;
  sum.convertTo(image, CV_8UC1);
  return image;
}

}  // namespace deja_view::test
