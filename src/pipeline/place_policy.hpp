#pragma once

#include <vector>

#include "candidates.hpp"

namespace deja_view {

/// Decides which keyframes become places to recognise: those that have no other within `spacing_m`
/// [m] and `spacing_deg` [deg]; all when `spacing_m` is 0.
class PlacePolicy {
 public:
  PlacePolicy(double spacing_m, double spacing_deg);

  /// `places`: the cameras of all places in the world of the keyframe whose camera is `here`.
  bool IsNewPlace(const NearbyPlace& here, const std::vector<NearbyPlace>& places) const;

 private:
  double spacing_m_;
  double min_cosine_;
};

}  // namespace deja_view
