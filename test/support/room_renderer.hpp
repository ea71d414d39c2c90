#pragma once

#include "deja_view/views/view_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/core.hpp>

namespace deja_view {

/// Renders the inside of a box of 8 x 6 x 4 m about the origin, with patterned walls, exactly.
class RoomRenderer : public ViewRenderer {
 public:
  /// Standard deviation of all depths over the depth.
  explicit RoomRenderer(double relative_sigma = 0.01) : relative_sigma_(relative_sigma) {}

  RenderedView Render(const Camera& camera,
                      const Rigid3& T_N_C,
                      const ViewRenderOptions& options) const override {
    const cv::Size size(camera.width(), camera.height());
    RenderedView view{cv::Mat(size, CV_8UC1),
                      cv::Mat(size, CV_32FC1),
                      cv::Mat(size, CV_32FC1),
                      cv::Mat(size, CV_32FC1, cv::Scalar(1))};
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const Eigen::Vector3d ray = T_N_C.q * camera.Unproject({x, y});
        const double range = Range(T_N_C.t, ray);
        const double grey = options.gain * Pattern(T_N_C.t + range * ray) + options.bias;
        view.image.at<std::uint8_t>(y, x) =
            static_cast<std::uint8_t>(std::lround(std::clamp(255 * grey, 0.0, 255.0)));
        view.depth.at<float>(y, x) = static_cast<float>(range);
        view.depth_variance.at<float>(y, x) =
            static_cast<float>(std::pow(relative_sigma_ * range, 2));
      }
    }
    return view;
  }

  /// Distance to the wall from `p` along the unit vector `ray` [m].
  static double Range(const Eigen::Vector3d& p, const Eigen::Vector3d& ray) {
    const Eigen::Vector3d half(4, 3, 2);
    double range = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (ray[axis] != 0) {
        range = std::min(range, (std::copysign(half[axis], ray[axis]) - p[axis]) / ray[axis]);
      }
    }
    return range;
  }

  /// Squares of random grey, 0.1 m wide and 0.2 m apart, on a slow wave; from 0.1 to 0.9.
  static double Pattern(const Eigen::Vector3d& p) {
    const Eigen::Vector3d half(4, 3, 2);
    std::uint32_t hash = 2166136261U;
    double wave = 0;
    bool is_square = true;
    for (int axis = 0; axis < 3; ++axis) {
      const bool is_wall = half[axis] - std::abs(p[axis]) < 1e-6;
      const double cell = std::floor(5 * p[axis] + 1e-5);
      const double place = 5 * p[axis] - cell;
      is_square = is_square && (is_wall || (place > 0.25 && place < 0.75));
      hash = (hash ^ static_cast<std::uint32_t>(static_cast<std::int32_t>(cell))) * 16777619U;
      wave += std::sin(1.7 * p[axis] + axis);
    }
    hash ^= hash >> 15U;
    return 0.5 + wave / 30 +
           (is_square ? 0.3 * (static_cast<double>(hash % 1024U) / 511.5 - 1) : 0);
  }

 private:
  double relative_sigma_;
};

}  // namespace deja_view
