#include "deja_view/features/brief_extractor.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "select_corners.hpp"
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

// Offsets of both samples of each pair into an image of `stride` bytes per row.
struct SampleOffsets {
  SampleOffsets(const BriefPattern& pattern, std::ptrdiff_t stride) {
    for (std::size_t i = 0; i < pattern.pairs.size(); ++i) {
      const BriefPattern::Pair& p = pattern.pairs[i];
      first[i] = static_cast<std::int32_t>(p.y1 * stride + p.x1);
      second[i] = static_cast<std::int32_t>(p.y2 * stride + p.x2);
    }
  }
  std::array<std::int32_t, 256> first;
  std::array<std::int32_t, 256> second;
};

Descriptor Describe(const std::uint8_t* centre, const SampleOffsets& offsets) {
  Descriptor descriptor;
  for (std::size_t word = 0; word < 4; ++word) {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < 64; ++i) {
      const std::size_t k = 64 * word + i;
      // Eq. 2; the sum over 2^i below is Eq. 3.
      const bool is_darker = centre[offsets.first[k]] < centre[offsets.second[k]];
      bits |= static_cast<std::uint64_t>(is_darker) << i;
    }
    descriptor.words[word] = bits;
  }
  return descriptor;
}

Descriptor DescribeClamped(const cv::Mat& smooth, cv::Point p, const BriefPattern& pattern) {
  const auto sample = [&](int x, int y) {
    return smooth.at<std::uint8_t>(std::clamp(y, 0, smooth.rows - 1),
                                   std::clamp(x, 0, smooth.cols - 1));
  };
  Descriptor descriptor;
  for (std::size_t i = 0; i < pattern.pairs.size(); ++i) {
    const BriefPattern::Pair& pair = pattern.pairs[i];
    const bool is_darker =
        sample(p.x + pair.x1, p.y + pair.y1) < sample(p.x + pair.x2, p.y + pair.y2);
    descriptor.words[i / 64] |= static_cast<std::uint64_t>(is_darker) << (i % 64);
  }
  return descriptor;
}

BriefPattern Turned(const BriefPattern& pattern, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const auto turn =
      [&](std::int8_t x, std::int8_t y, std::int8_t* turned_x, std::int8_t* turned_y) {
        *turned_x = static_cast<std::int8_t>(std::lround(c * x - s * y));
        *turned_y = static_cast<std::int8_t>(std::lround(s * x + c * y));
      };
  BriefPattern turned;
  for (std::size_t i = 0; i < pattern.pairs.size(); ++i) {
    const BriefPattern::Pair& p = pattern.pairs[i];
    BriefPattern::Pair& t = turned.pairs[i];
    turn(p.x1, p.y1, &t.x1, &t.y1);
    turn(p.x2, p.y2, &t.x2, &t.y2);
  }
  return turned;
}

}  // namespace

BriefExtractor::BriefExtractor(const BriefOptions& options)
    : options_((CheckNone(options.Validate(), "options"), options)),
      pattern_(options.pattern_file.empty() ? DefaultBriefPattern()
                                            : ReadBriefPattern(options.pattern_file)),
      radius_(pattern_.Radius()) {
  for (int step = 0; step < VerticalField::kSteps; ++step) {
    turned_.push_back(Turned(pattern_, step * VerticalField::kStepAngle));
    turned_radius_ = std::max(turned_radius_, turned_.back().Radius());
  }
}

Features BriefExtractor::Extract(const cv::Mat& image,
                                 const VerticalField& vertical,
                                 const std::vector<cv::Point2f>& points,
                                 std::vector<Descriptor>* point_descriptors) const {
  DEJA_VIEW_CHECK_OP(image.type(), ==, CV_8UC1);
  DEJA_VIEW_CHECK(!image.empty());
  DEJA_VIEW_CHECK(points.empty() || point_descriptors != nullptr);
  const cv::Mat smooth = Smooth(image);
  const auto turn_at = [&](cv::Point p) {
    return VerticalField::NearestStep(
        vertical.Angle(static_cast<float>(p.x), static_cast<float>(p.y)));
  };
  // A turn's offsets are made when it first occurs.
  std::vector<std::optional<SampleOffsets>> offsets(turned_.size());
  const auto describe = [&](cv::Point p) {
    const std::size_t turn = turn_at(p);
    const int radius = turn == 0 ? radius_ : turned_radius_;
    const bool is_inside =
        p.x >= radius && p.y >= radius && p.x + radius < smooth.cols && p.y + radius < smooth.rows;
    if (!is_inside) {
      return DescribeClamped(smooth, p, turned_[turn]);
    }
    if (!offsets[turn]) {
      offsets[turn].emplace(turned_[turn], static_cast<std::ptrdiff_t>(smooth.step[0]));
    }
    return Describe(smooth.ptr<std::uint8_t>(p.y) + p.x, *offsets[turn]);
  };

  Features features;
  features.keypoints = Detect(image);
  features.descriptors.reserve(features.keypoints.size());
  for (Keypoint& keypoint : features.keypoints) {
    keypoint.angle = vertical.Angle(keypoint.x, keypoint.y);
    features.descriptors.push_back(
        describe({static_cast<int>(keypoint.x), static_cast<int>(keypoint.y)}));
  }
  if (point_descriptors != nullptr) {
    point_descriptors->clear();
    point_descriptors->reserve(points.size());
    for (const cv::Point2f& point : points) {
      point_descriptors->push_back(describe(ToPixel(point)));
    }
  }
  return features;
}

cv::Mat BriefExtractor::Smooth(const cv::Mat& image) const {
  if (options_.smoothing_kernel_px == 1) {
    return image;
  }
  // Isolated: a part of a larger image gives what a copy of that part gives.
  cv::Mat smooth;
  cv::GaussianBlur(image,
                   smooth,
                   {options_.smoothing_kernel_px, options_.smoothing_kernel_px},
                   options_.smoothing_sigma_px,
                   options_.smoothing_sigma_px,
                   cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED);
  return smooth;
}

// Eq. 1, asked of nine neighbours on the circle in a row.
std::vector<Keypoint> BriefExtractor::Detect(const cv::Mat& image) const {
  // One pixel more than needed: non-maximum suppression looks at the neighbours.
  const int border = std::max(radius_ - internal::kFastRadius - 1, 0);
  const cv::Rect searched(border, border, image.cols - 2 * border, image.rows - 2 * border);
  if (searched.width <= 2 * internal::kFastRadius || searched.height <= 2 * internal::kFastRadius) {
    return {};
  }
  std::vector<cv::KeyPoint> corners;
  cv::FAST(
      image(searched), corners, options_.fast_threshold, true, cv::FastFeatureDetector::TYPE_9_16);
  const cv::Rect2f describable(
      cv::Rect(radius_, radius_, image.cols - 2 * radius_, image.rows - 2 * radius_));
  const auto shift = static_cast<float>(border);
  for (cv::KeyPoint& corner : corners) {
    corner.pt += cv::Point2f(shift, shift);
  }
  corners.erase(
      std::remove_if(corners.begin(),
                     corners.end(),
                     [&](const cv::KeyPoint& corner) { return !describable.contains(corner.pt); }),
      corners.end());
  const auto max_count = static_cast<std::size_t>(options_.max_features);
  if (options_.cell_size_px > 0) {
    internal::KeepSpread(max_count, options_.cell_size_px, &corners);
  } else {
    internal::KeepStrongest(max_count, &corners);
  }
  std::vector<Keypoint> keypoints;
  keypoints.reserve(corners.size());
  for (const cv::KeyPoint& corner : corners) {
    keypoints.push_back({corner.pt.x, corner.pt.y, corner.response, 0.0F, 0});
  }
  return keypoints;
}

cv::Point BriefExtractor::ToPixel(const cv::Point2f& point) const {
  // Clamped far outside any image, so that the conversion to int is defined for every finite value.
  const auto to_int = [this](float value) {
    if (!std::isfinite(value)) {
      return 0;
    }
    const float limited = std::clamp(value, -30000.0F, 30000.0F);
    return static_cast<int>(options_.point_rounding == PixelRounding::kNearest
                                ? std::lround(limited)
                                : static_cast<long>(limited));
  };
  return {to_int(point.x), to_int(point.y)};
}

}  // namespace deja_view
