#include "deja_view/views/depth_warp_renderer.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

constexpr double kMaxRangeRatio = 1.25;  // across 4 px; more is an edge, and a hole

// A place of the real image as the virtual camera sees it.
struct Vertex {
  Eigen::Vector2d virtual_pixel;
  Eigen::Vector2d real_pixel;
  double range_m = 0;  // from the virtual camera
};

// What each pixel of the virtual image shows.
struct Surface {
  cv::Mat range;   // CV_32FC1, infinity: nothing
  cv::Mat real_x;  // CV_32FC1 [px]
  cv::Mat real_y;
};

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

void DrawTriangle(const std::array<const Vertex*, 3>& v, Surface* surface) {
  const Eigen::Vector2d a = v[0]->virtual_pixel;
  const Eigen::Vector2d e1 = v[1]->virtual_pixel - a;
  const Eigen::Vector2d e2 = v[2]->virtual_pixel - a;
  const double area = Cross(e1, e2);
  if (!(area > 0)) {
    return;  // seen from behind
  }
  const auto bounds = [&](int axis, int side) {
    const auto [low, high] = std::minmax(
        {v[0]->virtual_pixel[axis], v[1]->virtual_pixel[axis], v[2]->virtual_pixel[axis]});
    return std::make_pair(static_cast<int>(std::ceil(std::clamp(low, 0.0, side + 0.0))),
                          static_cast<int>(std::floor(std::clamp(high, -1.0, side - 1.0))));
  };
  const auto [x0, x1] = bounds(0, surface->range.cols);
  const auto [y0, y1] = bounds(1, surface->range.rows);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const Eigen::Vector2d p = Eigen::Vector2d(x, y) - a;
      const double w1 = Cross(p, e2) / area;
      const double w2 = Cross(e1, p) / area;
      const double w0 = 1 - w1 - w2;
      // Rounding must not leave cracks between neighbours.
      if (std::min({w0, w1, w2}) < -1e-9) {
        continue;
      }
      const auto range =
          static_cast<float>(w0 * v[0]->range_m + w1 * v[1]->range_m + w2 * v[2]->range_m);
      if (range < surface->range.at<float>(y, x)) {
        const Eigen::Vector2d real =
            w0 * v[0]->real_pixel + w1 * v[1]->real_pixel + w2 * v[2]->real_pixel;
        surface->range.at<float>(y, x) = range;
        surface->real_x.at<float>(y, x) = static_cast<float>(real.x());
        surface->real_y.at<float>(y, x) = static_cast<float>(real.y());
      }
    }
  }
}

std::optional<Vertex> MakeVertex(const Camera& real_camera,
                                 const Camera& virtual_camera,
                                 const Rigid3& T_V_C,
                                 const cv::Mat& range_m,
                                 int x,
                                 int y) {
  const auto range = static_cast<double>(range_m.at<float>(y, x));
  if (!(range > 0)) {
    return std::nullopt;
  }
  const Eigen::Vector2d pixel(x, y);
  const Eigen::Vector3d p_V = T_V_C * (range * real_camera.Unproject(pixel));
  const std::optional<Eigen::Vector2d> projected = virtual_camera.Project(p_V);
  if (!projected) {
    return std::nullopt;
  }
  return Vertex{*projected, pixel, p_V.norm()};
}

std::vector<int> MeshLines(int size, int step) {
  std::vector<int> lines;
  for (int i = 0; i < size - 1; i += step) {
    lines.push_back(i);
  }
  lines.push_back(size - 1);
  return lines;
}

bool IsSmooth(const std::array<const Vertex*, 3>& v, double max_ratio) {
  const auto [low, high] = std::minmax({v[0]->range_m, v[1]->range_m, v[2]->range_m});
  return high <= max_ratio * low;
}

void DrawCell(const std::array<const std::optional<Vertex>*, 4>& corners,
              double max_ratio,
              Surface* surface) {
  // Corners: top left, top right, bottom left, bottom right.
  for (const auto& [a, b, c] : {std::array<std::size_t, 3>{0, 1, 2}, {1, 3, 2}}) {
    if (*corners[a] && *corners[b] && *corners[c]) {
      const std::array<const Vertex*, 3> triangle = {
          &corners[a]->value(), &corners[b]->value(), &corners[c]->value()};
      if (IsSmooth(triangle, max_ratio)) {
        DrawTriangle(triangle, surface);
      }
    }
  }
}

// Grey values of the nearest known pixels where `is_hole` is not 0.
void FillHoles(const cv::Mat& is_hole, cv::Mat* image) {
  if (cv::countNonZero(is_hole) == 0 || cv::countNonZero(is_hole == 0) == 0) {
    return;
  }
  cv::Mat distance;
  cv::Mat labels;
  cv::distanceTransform(
      is_hole, distance, labels, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<std::uint8_t> grey(is_hole.total() + 1, 0);
  for (int y = 0; y < image->rows; ++y) {
    for (int x = 0; x < image->cols; ++x) {
      if (is_hole.at<std::uint8_t>(y, x) == 0) {
        grey[static_cast<std::size_t>(labels.at<int>(y, x))] = image->at<std::uint8_t>(y, x);
      }
    }
  }
  for (int y = 0; y < image->rows; ++y) {
    for (int x = 0; x < image->cols; ++x) {
      image->at<std::uint8_t>(y, x) = grey[static_cast<std::size_t>(labels.at<int>(y, x))];
    }
  }
}

}  // namespace

RangeMap DensifyRanges(const std::vector<RangeSample>& samples, cv::Size size) {
  constexpr int kStep = 8;            // [px] of the grid on which weights are summed
  constexpr double kSoftness = 12.0;  // h [px]
  const cv::Size coarse((size.width + kStep - 1) / kStep + 1,
                        (size.height + kStep - 1) / kStep + 1);
  cv::Mat inverse = cv::Mat::zeros(coarse, CV_32FC1);
  cv::Mat variance = cv::Mat::zeros(coarse, CV_32FC1);
  for (int y = 0; y < coarse.height; ++y) {
    for (int x = 0; x < coarse.width; ++x) {
      double sum = 0;
      double sum_i = 0;
      double sum_ii = 0;
      for (const RangeSample& sample : samples) {
        if (!(sample.range_m > 0 && std::isfinite(sample.range_m) && sample.pixel.allFinite())) {
          continue;
        }
        const double d2 = (sample.pixel - kStep * Eigen::Vector2d(x, y)).squaredNorm();
        const double w = 1 / std::pow(d2 + kSoftness * kSoftness, 2);
        sum += w;
        sum_i += w / sample.range_m;
        sum_ii += w / (sample.range_m * sample.range_m);
      }
      if (sum > 0) {
        const double mean = sum_i / sum;
        inverse.at<float>(y, x) = static_cast<float>(mean);
        variance.at<float>(y, x) = static_cast<float>(std::max(0.0, sum_ii / sum - mean * mean));
      }
    }
  }
  // Pixel (x, y) lies at (x, y) / kStep of the grid.
  const cv::Matx23d to_grid(1.0 / kStep, 0, 0, 0, 1.0 / kStep, 0);
  cv::Mat fine;
  cv::Mat fine_variance;
  constexpr int kFlags = cv::INTER_LINEAR | cv::WARP_INVERSE_MAP;
  cv::warpAffine(inverse, fine, to_grid, size, kFlags, cv::BORDER_REPLICATE);
  cv::warpAffine(variance, fine_variance, to_grid, size, kFlags, cv::BORDER_REPLICATE);
  RangeMap map{cv::Mat::zeros(size, CV_32FC1), cv::Mat::zeros(size, CV_32FC1)};
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const float i = fine.at<float>(y, x);
      if (i > 0) {
        map.range_m.at<float>(y, x) = 1 / i;
        map.variance.at<float>(y, x) = fine_variance.at<float>(y, x) / (i * i * i * i);
      }
    }
  }
  return map;
}

RangeMap DensifyDepthImage(const cv::Mat& range_m) {
  DEJA_VIEW_CHECK(range_m.type() == CV_32FC1);
  constexpr float kSigma = 0.01F;       // of a known range
  constexpr double kBlur_px = 3;        // about a gap
  constexpr float kLeastKnown = 0.02F;  // share of what is about an unknown pixel: 6 px off an edge
  const cv::Mat is_known = range_m > 0;
  cv::Mat inverse = cv::Mat::zeros(range_m.size(), CV_32FC1);
  cv::divide(1.0, range_m, inverse);
  inverse.setTo(0, is_known == 0);
  const auto blur = [&](const cv::Mat& from) {
    cv::Mat to;
    cv::GaussianBlur(from, to, {17, 17}, kBlur_px, kBlur_px, cv::BORDER_CONSTANT);
    return to;
  };
  cv::Mat known;
  is_known.convertTo(known, CV_32FC1, 1.0 / 255);
  const cv::Mat weight = blur(known);
  const cv::Mat first = blur(inverse);
  const cv::Mat second = blur(inverse.mul(inverse));
  RangeMap map{range_m.clone(), cv::Mat(kSigma * kSigma * range_m.mul(range_m))};
  for (int y = 0; y < range_m.rows; ++y) {
    for (int x = 0; x < range_m.cols; ++x) {
      const float w = weight.at<float>(y, x);
      if (is_known.at<std::uint8_t>(y, x) == 0 && w > kLeastKnown) {
        const float mean = first.at<float>(y, x) / w;
        const float spread = std::max(0.0F, second.at<float>(y, x) / w - mean * mean);
        map.range_m.at<float>(y, x) = 1 / mean;
        map.variance.at<float>(y, x) = (spread / (mean * mean) + kSigma * kSigma) / (mean * mean);
      }
    }
  }
  return map;
}

DepthWarpRenderer::DepthWarpRenderer(cv::Mat image,
                                     RangeMap ranges,
                                     std::shared_ptr<const Camera> camera,
                                     const Rigid3& T_N_C,
                                     int mesh_step_px)
    : image_(std::move(image)),
      ranges_(std::move(ranges)),
      camera_(std::move(camera)),
      T_N_C_(T_N_C),
      mesh_step_px_(mesh_step_px) {
  DEJA_VIEW_CHECK(mesh_step_px_ > 0);
  const cv::Size size(camera_->width(), camera_->height());
  DEJA_VIEW_CHECK(image_.type() == CV_8UC1 && image_.size() == size);
  DEJA_VIEW_CHECK(ranges_.range_m.size() == size && ranges_.variance.size() == size);
}

RenderedView DepthWarpRenderer::Render(const Camera& camera,
                                       const Rigid3& T_N_V,
                                       const ViewRenderOptions& options) const {
  const cv::Size size(camera.width(), camera.height());
  Surface surface{cv::Mat(size, CV_32FC1, cv::Scalar(std::numeric_limits<float>::infinity())),
                  cv::Mat(size, CV_32FC1, cv::Scalar(-1)),
                  cv::Mat(size, CV_32FC1, cv::Scalar(-1))};
  const Rigid3 T_V_C = T_N_V.Inverse() * T_N_C_;
  const std::vector<int> xs = MeshLines(image_.cols, mesh_step_px_);
  const double max_ratio = std::pow(kMaxRangeRatio, mesh_step_px_ / 4.0);
  std::vector<std::optional<Vertex>> above;
  std::vector<std::optional<Vertex>> row;
  for (const int y : MeshLines(image_.rows, mesh_step_px_)) {
    row.clear();
    for (const int x : xs) {
      row.push_back(MakeVertex(*camera_, camera, T_V_C, ranges_.range_m, x, y));
    }
    for (std::size_t i = 0; i + 1 < xs.size() && !above.empty(); ++i) {
      DrawCell({&above[i], &above[i + 1], &row[i], &row[i + 1]}, max_ratio, &surface);
    }
    std::swap(above, row);
  }

  RenderedView view;
  const cv::Mat is_hole = surface.range == std::numeric_limits<float>::infinity();
  cv::remap(
      image_, view.image, surface.real_x, surface.real_y, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  FillHoles(is_hole, &view.image);
  view.image.convertTo(view.image,
                       CV_8UC1,
                       static_cast<double>(options.gain),
                       255.0 * static_cast<double>(options.bias));
  view.depth = surface.range;
  view.depth.setTo(0, is_hole);
  cv::remap(ranges_.variance,
            view.depth_variance,
            surface.real_x,
            surface.real_y,
            cv::INTER_LINEAR,
            cv::BORDER_REPLICATE);
  view.depth_variance.setTo(0, is_hole);
  view.opacity = cv::Mat::ones(size, CV_32FC1);
  view.opacity.setTo(0, is_hole);
  return view;
}

}  // namespace deja_view
