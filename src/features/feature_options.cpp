#include "deja_view/features/feature_options.hpp"

#include <fmt/format.h>

namespace deja_view {
namespace {

// Collects "key: value, expected ..." for what does not hold.
class Requirements {
 public:
  template <typename T>
  void Require(bool holds, const char* key, const T& value, const char* expected) {
    if (!holds) {
      violations_.push_back(fmt::format("{}: {}, expected {}", key, value, expected));
    }
  }

  std::vector<std::string> Take() { return std::move(violations_); }

 private:
  std::vector<std::string> violations_;
};

}  // namespace

std::vector<std::string> BriefOptions::Validate() const {
  Requirements r;
  r.Require(max_features >= 1, "max_features", max_features, "at least 1");
  r.Require(
      fast_threshold >= 1 && fast_threshold <= 254, "fast_threshold", fast_threshold, "1 to 254");
  r.Require(cell_size_px >= 0, "cell_size_px", cell_size_px, "0 or more");
  r.Require(smoothing_kernel_px >= 1 && smoothing_kernel_px <= 31 && smoothing_kernel_px % 2 == 1,
            "smoothing_kernel_px",
            smoothing_kernel_px,
            "an odd number from 1 to 31");
  r.Require(smoothing_sigma_px > 0 && smoothing_sigma_px < 100,
            "smoothing_sigma_px",
            smoothing_sigma_px,
            "more than 0, less than 100");
  return r.Take();
}

std::vector<std::string> OrbOptions::Validate() const {
  Requirements r;
  r.Require(max_features >= 1, "max_features", max_features, "at least 1");
  r.Require(scale_factor >= 1.01 && scale_factor <= 2, "scale_factor", scale_factor, "1.01 to 2");
  r.Require(levels >= 1 && levels <= 16, "levels", levels, "1 to 16");
  r.Require(
      fast_threshold >= 1 && fast_threshold <= 254, "fast_threshold", fast_threshold, "1 to 254");
  r.Require(min_fast_threshold >= 1 && min_fast_threshold <= fast_threshold,
            "min_fast_threshold",
            min_fast_threshold,
            "1 to fast_threshold");
  r.Require(cell_size_px >= 8, "cell_size_px", cell_size_px, "at least 8");
  r.Require(adaptive_factor > 0 && adaptive_factor < 100,
            "adaptive_factor",
            adaptive_factor,
            "more than 0, less than 100");
  return r.Take();
}

std::vector<std::string> FeatureOptions::Validate() const {
  std::vector<std::string> violations =
      kind == FeatureKind::kBrief ? brief.Validate() : orb.Validate();
  for (std::string& violation : violations) {
    violation.insert(0, EnumToString(kind) + ".");
  }
  return violations;
}

}  // namespace deja_view
