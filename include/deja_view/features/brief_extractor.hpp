#pragma once

#include "deja_view/features/brief_pattern.hpp"
#include "deja_view/features/feature_extractor.hpp"
#include "deja_view/features/feature_options.hpp"

namespace deja_view {

/// FAST corners (segment test of 9 of 16 pixels, non-maximum suppression) with 256-bit BRIEF,
/// upright in the image or, where its VerticalField is known, in the world.
///
/// The descriptor is VINS-Mono's (DVision's BRIEF): the whole image is smoothed with a 9 x 9
/// Gaussian of sigma 2 px (`cv::GaussianBlur` on 8 bits, border reflected), and with S the smoothed
/// image and (x, y) the keypoint's pixel, bit i = S(x + x1_i, y + y1_i) < S(x + x2_i, y + y2_i).
/// Samples outside the image are clamped to it; VINS-Mono leaves such bits 0. Upright in the world,
/// the pattern is turned by the nearest step of VerticalField and rounded to pixels.
class BriefExtractor final : public FeatureExtractor {
 public:
  /// Throws CheckError for invalid options, InputError for a bad pattern file.
  explicit BriefExtractor(const BriefOptions& options = {});

  std::string DescriptorName() const override { return "brief"; }
  using FeatureExtractor::Extract;
  Features Extract(const cv::Mat& image,
                   const VerticalField& vertical,
                   const std::vector<cv::Point2f>& points,
                   std::vector<Descriptor>* point_descriptors) const override;

  const BriefPattern& pattern() const { return pattern_; }

 private:
  cv::Mat Smooth(const cv::Mat& image) const;
  std::vector<Keypoint> Detect(const cv::Mat& image) const;
  cv::Point ToPixel(const cv::Point2f& point) const;

  BriefOptions options_;
  BriefPattern pattern_;
  std::vector<BriefPattern> turned_;  ///< by whole steps of a turn; the first is pattern_
  int radius_;
  int turned_radius_ = 0;  ///< of all turns
};

}  // namespace deja_view
