#include "deja_view/features/orb_extractor.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "quadtree.hpp"
#include "select_corners.hpp"
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

constexpr int kDiscRadius = 15;  // of the intensity centroid
constexpr int kBorder = 19;      // reach of the rotated pattern, a patch of 31 px
constexpr int kPadding = 40;
constexpr float kRadians = static_cast<float>(kDegree);

// Half width of the disc's rows 0 to 15. A pixel (u, v) belongs to OpenCV's disc when the larger of
// |u| and |v| is at most sqrt(15^2 - smaller^2), rounded: a disc that is symmetric under swapping x
// and y.
std::array<int, kDiscRadius + 1> DiscHalfWidths() {
  const auto is_inside = [](int u, int v) {
    const int smaller = std::min(u, v);
    return std::max(u, v) <= std::lround(std::sqrt(kDiscRadius * kDiscRadius - smaller * smaller));
  };
  std::array<int, kDiscRadius + 1> widths{};
  for (int v = 0; v <= kDiscRadius; ++v) {
    while (widths[v] < kDiscRadius && is_inside(widths[v] + 1, v)) {
      ++widths[v];
    }
  }
  return widths;
}

// Corners of one pyramid level that can be described, in its own coordinates, not yet thinned.
std::vector<cv::KeyPoint> DetectOnLevel(const cv::Mat& level, int threshold) {
  const int margin = kBorder - internal::kFastRadius - 1;
  const cv::Rect describable(kBorder, kBorder, level.cols - 2 * kBorder, level.rows - 2 * kBorder);
  if (describable.width <= 0 || describable.height <= 0) {
    return {};
  }
  const cv::Rect searched(margin, margin, level.cols - 2 * margin, level.rows - 2 * margin);
  std::vector<cv::KeyPoint> corners;
  cv::FAST(level(searched), corners, threshold, true, cv::FastFeatureDetector::TYPE_9_16);
  for (cv::KeyPoint& corner : corners) {
    corner.pt += cv::Point2f(margin, margin);
  }
  const cv::Rect2f limits(describable);
  corners.erase(
      std::remove_if(corners.begin(),
                     corners.end(),
                     [&](const cv::KeyPoint& corner) { return !limits.contains(corner.pt); }),
      corners.end());
  return corners;
}

// A corner's response is the largest threshold at which it is one, so that raising the threshold
// afterwards equals detecting with it. `threshold_of(cell_index, corners_of_cell)` gives the cell's
// threshold.
template <typename ThresholdOf>
void RaiseThresholds(const cv::Mat& level,
                     int cell_size,
                     const ThresholdOf& threshold_of,
                     std::vector<cv::KeyPoint>* corners) {
  const int columns = (level.cols + cell_size - 1) / cell_size;
  const int rows = (level.rows + cell_size - 1) / cell_size;
  const auto cell_of = [&](const cv::KeyPoint& corner) {
    return static_cast<int>(corner.pt.y) / cell_size * columns +
           static_cast<int>(corner.pt.x) / cell_size;
  };
  std::vector<float> strongest(static_cast<std::size_t>(columns) * rows, 0.0F);
  for (const cv::KeyPoint& corner : *corners) {
    float& cell = strongest[cell_of(corner)];
    cell = std::max(cell, corner.response);
  }
  std::vector<float> thresholds(strongest.size());
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const cv::Rect cell = cv::Rect(column * cell_size, row * cell_size, cell_size, cell_size) &
                            cv::Rect({0, 0}, level.size());
      const int i = row * columns + column;
      thresholds[i] = threshold_of(cell, strongest[i]);
    }
  }
  corners->erase(std::remove_if(corners->begin(),
                                corners->end(),
                                [&](const cv::KeyPoint& corner) {
                                  return corner.response < thresholds[cell_of(corner)];
                                }),
                 corners->end());
}

double StandardDeviation(const cv::Mat& image) {
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(image, mean, deviation);
  return deviation[0];
}

std::vector<cv::KeyPoint> SelectOnLevel(const cv::Mat& level,
                                        const OrbOptions& options,
                                        std::size_t max_count,
                                        std::vector<cv::KeyPoint> corners) {
  const cv::Rect whole({0, 0}, level.size());
  if (options.quadtree == QuadtreeMode::kAdaptiveFast) {
    const auto threshold_of = [&](const cv::Rect& cell, float /*strongest*/) {
      return static_cast<float>(options.adaptive_factor * StandardDeviation(level(cell)));
    };
    RaiseThresholds(level, options.cell_size_px, threshold_of, &corners);
    return internal::SelectByQuadtree(corners, whole, max_count);
  }
  const auto threshold_of = [&](const cv::Rect& /*cell*/, float strongest) {
    const auto high = static_cast<float>(options.fast_threshold);
    return strongest >= high ? high : 0.0F;
  };
  RaiseThresholds(level, options.cell_size_px, threshold_of, &corners);
  if (options.quadtree == QuadtreeMode::kCount) {
    return internal::SelectByQuadtree(corners, whole, max_count);
  }
  // Eq. 7 as corrected, for each quarter of the level.
  std::vector<cv::KeyPoint> kept;
  const int x = level.cols / 2;
  const int y = level.rows / 2;
  for (const cv::Rect& quarter : {cv::Rect(0, 0, x, y),
                                  cv::Rect(x, 0, level.cols - x, y),
                                  cv::Rect(0, y, x, level.rows - y),
                                  cv::Rect(x, y, level.cols - x, level.rows - y)}) {
    const auto target =
        std::max<std::size_t>(1, static_cast<std::size_t>(StandardDeviation(level(quarter))));
    const auto of_quarter = internal::SelectByQuadtree(corners, quarter, target);
    kept.insert(kept.end(), of_quarter.begin(), of_quarter.end());
  }
  internal::KeepStrongest(max_count, &kept);
  return kept;
}

// Descriptors of keypoints at least kBorder from the border of `level`, in their order.
std::vector<Descriptor> DescribeOnLevel(const cv::Mat& level, std::vector<cv::KeyPoint> keypoints) {
  std::vector<Descriptor> descriptors(keypoints.size());
  if (keypoints.empty()) {
    return descriptors;
  }
  for (cv::KeyPoint& keypoint : keypoints) {
    keypoint.octave = 0;
  }
  const std::size_t count = keypoints.size();
  cv::Mat rows;
  cv::ORB::create(1, 1.2F, 1, kBorder, 0, 2, cv::ORB::HARRIS_SCORE, 31)
      ->compute(level, keypoints, rows);
  DEJA_VIEW_CHECK_OP(keypoints.size(), ==, count);
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(descriptors[i].words.data(), rows.ptr(static_cast<int>(i)), sizeof(Descriptor));
  }
  return descriptors;
}

std::vector<int> SharesOfLevels(const OrbOptions& options) {
  // Levels have shares proportional to their side length; rounding falls to the last.
  const double ratio = 1.0 / options.scale_factor;
  double share = options.max_features * (1.0 - ratio) / (1.0 - std::pow(ratio, options.levels));
  std::vector<int> shares;
  int given = 0;
  for (int level = 0; level + 1 < options.levels; ++level) {
    shares.push_back(std::min(static_cast<int>(std::lround(share)), options.max_features - given));
    given += shares.back();
    share *= ratio;
  }
  shares.push_back(options.max_features - given);
  return shares;
}

// Levels of the pyramid as cv::ORB builds it.
std::vector<cv::Mat> BuildPyramid(const cv::Mat& image, const OrbOptions& options) {
  std::vector<cv::Mat> pyramid = {image};
  for (int level = 1; level < options.levels; ++level) {
    const auto scale = static_cast<float>(
        std::pow(static_cast<double>(static_cast<float>(options.scale_factor)), level));
    const float inverse = 1.0F / scale;
    const cv::Size size(cvRound(static_cast<float>(image.cols) * inverse),
                        cvRound(static_cast<float>(image.rows) * inverse));
    if (size.width < 1 || size.height < 1) {
      break;
    }
    cv::Mat resized;
    cv::resize(pyramid.back(), resized, size, 0, 0, cv::INTER_LINEAR_EXACT);
    pyramid.push_back(resized);
  }
  return pyramid;
}

float AngleDeg(const VerticalField& vertical, float x, float y) {
  return vertical.Angle(x, y) / kRadians;
}

std::vector<Descriptor> DescribePoints(const cv::Mat& image,
                                       const std::vector<cv::Point2f>& points,
                                       const VerticalField& vertical) {
  if (points.empty()) {
    return {};
  }
  cv::Mat padded;
  cv::copyMakeBorder(image,
                     padded,
                     kPadding,
                     kPadding,
                     kPadding,
                     kPadding,
                     cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED);
  const auto to_pixel = [](float value, int size) {
    const float limited =
        std::isfinite(value) ? std::clamp(value, 0.0F, static_cast<float>(size - 1)) : 0.0F;
    return static_cast<int>(std::lround(limited)) + kPadding;
  };
  std::vector<cv::KeyPoint> keypoints;
  keypoints.reserve(points.size());
  for (const cv::Point2f& point : points) {
    const cv::Point pixel(to_pixel(point.x, image.cols), to_pixel(point.y, image.rows));
    const float angle = vertical.empty() ? internal::IntensityCentroidAngle(padded, pixel)
                                         : AngleDeg(vertical, point.x, point.y);
    keypoints.emplace_back(pixel, 31.0F, angle);
  }
  return DescribeOnLevel(padded, std::move(keypoints));
}

}  // namespace

namespace internal {

float IntensityCentroidAngle(const cv::Mat& image, cv::Point centre) {
  static const std::array<int, kDiscRadius + 1> half_widths = DiscHalfWidths();
  int m01 = 0;
  int m10 = 0;
  for (int v = -kDiscRadius; v <= kDiscRadius; ++v) {
    const int half_width = half_widths[std::abs(v)];
    const std::uint8_t* row = image.ptr<std::uint8_t>(centre.y + v) + centre.x;
    int sum = 0;
    for (int u = -half_width; u <= half_width; ++u) {
      sum += row[u];
      m10 += u * row[u];
    }
    m01 += v * sum;
  }
  return cv::fastAtan2(static_cast<float>(m01), static_cast<float>(m10));
}

}  // namespace internal

OrbExtractor::OrbExtractor(const OrbOptions& options)
    : options_((CheckNone(options.Validate(), "options"), options)),
      level_features_(SharesOfLevels(options)) {}

Features OrbExtractor::Extract(const cv::Mat& image,
                               const VerticalField& vertical,
                               const std::vector<cv::Point2f>& points,
                               std::vector<Descriptor>* point_descriptors) const {
  DEJA_VIEW_CHECK_OP(image.type(), ==, CV_8UC1);
  DEJA_VIEW_CHECK(!image.empty());
  DEJA_VIEW_CHECK(points.empty() || point_descriptors != nullptr);
  const std::vector<cv::Mat> pyramid = BuildPyramid(image, options_);
  const int threshold = options_.min_fast_threshold;
  Features features;
  for (std::size_t l = 0; l < pyramid.size(); ++l) {
    const cv::Mat& level = pyramid[l];
    std::vector<cv::KeyPoint> corners = SelectOnLevel(level,
                                                      options_,
                                                      static_cast<std::size_t>(level_features_[l]),
                                                      DetectOnLevel(level, threshold));
    const float scale_x = static_cast<float>(image.cols) / static_cast<float>(level.cols);
    const float scale_y = static_cast<float>(image.rows) / static_cast<float>(level.rows);
    for (cv::KeyPoint& corner : corners) {
      corner.angle = vertical.empty()
                         ? internal::IntensityCentroidAngle(level, corner.pt)
                         : AngleDeg(vertical, corner.pt.x * scale_x, corner.pt.y * scale_y);
    }
    const std::vector<Descriptor> descriptors = DescribeOnLevel(level, corners);
    features.descriptors.insert(features.descriptors.end(), descriptors.begin(), descriptors.end());
    for (const cv::KeyPoint& corner : corners) {
      features.keypoints.push_back({(corner.pt.x + 0.5F) * scale_x - 0.5F,
                                    (corner.pt.y + 0.5F) * scale_y - 0.5F,
                                    corner.response,
                                    corner.angle * kRadians,
                                    static_cast<std::int32_t>(l)});
    }
  }
  if (point_descriptors != nullptr) {
    *point_descriptors = DescribePoints(image, points, vertical);
  }
  return features;
}

}  // namespace deja_view
