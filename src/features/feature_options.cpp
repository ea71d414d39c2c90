#include "deja_view/features/feature_options.hpp"

#include "deja_view/base/requirements.hpp"

namespace deja_view {
std::vector<std::string> BriefOptions::Validate() const {
  Requirements r;
  r.That(max_features >= 1, "max_features", max_features, "at least 1");
  r.Range("fast_threshold", fast_threshold, 1, 254);
  r.That(cell_size_px >= 0, "cell_size_px", cell_size_px, "0 or more");
  r.That(smoothing_kernel_px >= 1 && smoothing_kernel_px <= 31 && smoothing_kernel_px % 2 == 1,
         "smoothing_kernel_px",
         smoothing_kernel_px,
         "an odd number from 1 to 31");
  r.That(smoothing_sigma_px > 0 && smoothing_sigma_px < 100,
         "smoothing_sigma_px",
         smoothing_sigma_px,
         "more than 0, less than 100");
  return r.errors();
}

std::vector<std::string> OrbOptions::Validate() const {
  Requirements r;
  r.That(max_features >= 1, "max_features", max_features, "at least 1");
  r.Range("scale_factor", scale_factor, 1.01, 2);
  r.Range("levels", levels, 1, 16);
  r.Range("fast_threshold", fast_threshold, 1, 254);
  r.That(min_fast_threshold >= 1 && min_fast_threshold <= fast_threshold,
         "min_fast_threshold",
         min_fast_threshold,
         "1 to fast_threshold");
  r.That(cell_size_px >= 8, "cell_size_px", cell_size_px, "at least 8");
  r.That(adaptive_factor > 0 && adaptive_factor < 100,
         "adaptive_factor",
         adaptive_factor,
         "more than 0, less than 100");
  return r.errors();
}

std::vector<std::string> FeatureOptions::Validate() const {
  Requirements r;
  r.Group(EnumToString(kind).c_str(),
          kind == FeatureKind::kBrief ? brief.Validate() : orb.Validate());
  return r.errors();
}

std::string DescriptorKind(const FeatureOptions& options) {
  const std::string kind = EnumToString(options.kind);
  return options.orientation == PatchOrientation::kImage
             ? kind
             : kind + "@" + EnumToString(options.orientation);
}

}  // namespace deja_view
