#include "deja_view/nerf/depth_metrics.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view::nerf {
namespace {

// The pixel of an image of `to` pixels at the centre of pixel `i` of one of `from` pixels.
int Nearest(int i, int from, int to) {
  return std::min(to - 1, static_cast<int>((i + 0.5) * to / from));
}

}  // namespace

std::vector<float> RelativeDepthErrors(const cv::Mat& real, const cv::Mat& rendered) {
  DEJA_VIEW_CHECK(real.type() == CV_32FC1 && rendered.type() == CV_32FC1);
  std::vector<float> errors;
  for (int y = 0; y < rendered.rows; ++y) {
    const auto* row = real.ptr<float>(Nearest(y, rendered.rows, real.rows));
    for (int x = 0; x < rendered.cols; ++x) {
      const float truth = row[Nearest(x, rendered.cols, real.cols)];
      if (truth > 0) {
        errors.push_back(std::abs(rendered.at<float>(y, x) - truth) / truth);
      }
    }
  }
  return errors;
}

}  // namespace deja_view::nerf
