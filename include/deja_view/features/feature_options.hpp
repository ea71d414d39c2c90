#pragma once

#include "deja_view/base/enum_names.hpp"

#include <string>
#include <vector>

namespace deja_view {

/// How a tracked point's sub-pixel position becomes the pixel that BRIEF is centred on.
enum class PixelRounding {
  kNearest,   ///< nearest pixel
  kTruncate,  ///< towards zero, as VINS-Mono does: half a pixel up and left on average
};

template <>
struct EnumNames<PixelRounding> {
  static constexpr std::pair<PixelRounding, const char*> kNames[] = {
      {PixelRounding::kNearest, "nearest"}, {PixelRounding::kTruncate, "truncate"}};
};

/// Options of BriefExtractor.
struct BriefOptions {
  int max_features = 1000;   ///< strongest corners kept; >= 1
  int fast_threshold = 20;   ///< grey levels, 1 to 254
  int cell_size_px = 48;     ///< corners are spread over square cells of this size; 0: no spreading
  std::string pattern_file;  ///< brief_pattern.yml; empty: the package's own pattern
  int smoothing_kernel_px = 9;  ///< odd size of the Gaussian kernel; 1: no smoothing
  double smoothing_sigma_px = 2.0;
  PixelRounding point_rounding = PixelRounding::kNearest;

  /// Violations, one line each; empty when all is well.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("max_features", max_features);
    v("fast_threshold", fast_threshold);
    v("cell_size_px", cell_size_px);
    v("pattern_file", pattern_file);
    v("smoothing_kernel_px", smoothing_kernel_px);
    v("smoothing_sigma_px", smoothing_sigma_px);
    v("point_rounding", point_rounding);
  }
};

}  // namespace deja_view
