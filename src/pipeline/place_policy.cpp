#include "place_policy.hpp"

#include "deja_view/base/angles.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view {

PlacePolicy::PlacePolicy(double spacing_m, double spacing_deg)
    : spacing_m_(spacing_m), min_cosine_(std::cos(spacing_deg * kDegree)) {}

bool PlacePolicy::IsNewPlace(const NearbyPlace& here,
                             const std::vector<NearbyPlace>& places) const {
  return spacing_m_ <= 0 ||
         std::none_of(places.begin(), places.end(), [&](const NearbyPlace& place) {
           return (place.position_M - here.position_M).norm() < spacing_m_ &&
                  place.axis_M.dot(here.axis_M) > min_cosine_;
         });
}

}  // namespace deja_view
