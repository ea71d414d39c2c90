#include "deja_view/bundle/bundle_adjuster.hpp"

#include <fmt/format.h>

namespace deja_view {

std::string BundleSummary::ToString() const {
  std::string text;
  for (const BundleRound& r : rounds) {
    text += fmt::format(
        "within {:.1f} px: {} pairs, {} matches, {} tracks, {} points; adjusted {} with {} "
        "observations, {} iterations: RMS {:.3f} -> {:.3f} px; {:.1f} + {:.1f} s\n",
        r.error_px,
        r.pairs,
        r.matches,
        r.tracks,
        r.points,
        r.adjusted_points,
        r.observations,
        r.iterations,
        r.rms_before_px,
        r.rms_after_px,
        r.matching_s,
        r.solving_s);
  }
  if (!is_usable()) {
    return text + "not adjusted: " + obstacle;
  }
  return text +
         fmt::format(
             "{} images ({} rest on their priors), {} points, {} observations ({:.1f} a point): "
             "RMS {:.3f} px, median {:.3f} px; moved {:.4f} m on average, {:.4f} m at most",
             images,
             weak_images,
             points,
             observations,
             mean_track,
             rms_px,
             median_px,
             mean_shift_m,
             largest_shift_m);
}

}  // namespace deja_view
