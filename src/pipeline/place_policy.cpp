#include "place_policy.hpp"

#include "deja_view/base/angles.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deja_view {

PlacePolicy::PlacePolicy(double spacing_m,
                         double spacing_deg,
                         const PlaceCoverOptions& cover,
                         std::shared_ptr<const Camera> camera)
    : spacing_m_(spacing_m),
      min_axis_cosine_(std::cos(ToRadians(spacing_deg))),
      cover_(cover),
      min_ray_cosine_(std::cos(ToRadians(cover.max_angle_deg))),
      camera_(std::move(camera)) {}

bool PlacePolicy::IsSpacedFrom(const NearbyPlace& place, const NearbyPlace& here) const {
  return (place.T_M_C.t - here.T_M_C.t).norm() >= spacing_m_ ||
         place.axis_M().dot(here.axis_M()) <= min_axis_cosine_;
}

PlacePolicy::Points PlacePolicy::Sample(const KeyframeFeatures& seen) const {
  constexpr std::size_t kMost = 64;
  constexpr std::size_t kFewest = 16;
  constexpr double kUnknownDepthM = 3.0;
  const Rigid3 T_C_B = seen.T_B_C.Inverse();
  Points points;
  const std::size_t step = 1 + seen.points_B.size() / kMost;
  for (std::size_t i = 0; i < seen.points_B.size(); i += step) {
    points.push_back(T_C_B * seen.points_B[i].cast<double>());
  }
  if (points.size() >= kFewest) {
    return points;
  }
  double depth = kUnknownDepthM;
  if (!points.empty()) {
    const auto middle = points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2);
    std::nth_element(points.begin(), middle, points.end(), [](const auto& a, const auto& b) {
      return a.squaredNorm() < b.squaredNorm();
    });
    depth = middle->norm();
  }
  points.clear();
  constexpr int kColumns = 8;
  constexpr int kRows = 6;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      points.push_back(depth * camera_->Unproject({camera_->width() * (column + 0.5) / kColumns,
                                                   camera_->height() * (row + 0.5) / kRows}));
    }
  }
  return points;
}

bool PlacePolicy::Covers(const Rigid3& T_place_here, const Points& points_here) const {
  const Eigen::Vector3d centre = T_place_here.Inverse().t;  // the place's camera, from here
  const double least = cover_.min_share * static_cast<double>(points_here.size());
  double covered = 0;
  double left = static_cast<double>(points_here.size());
  for (const Eigen::Vector3d& p : points_here) {
    const Eigen::Vector3d from_place = p - centre;
    const double here_m = p.norm();
    const double place_m = from_place.norm();
    const bool is_alike =
        std::max(here_m, place_m) <= cover_.max_scale * std::min(here_m, place_m) &&
        p.dot(from_place) >= min_ray_cosine_ * here_m * place_m;
    const auto pixel = is_alike ? camera_->Project(T_place_here * p) : std::nullopt;
    covered += pixel && camera_->IsInImage(*pixel) ? 1 : 0;
    left -= 1;
    if (covered >= least || covered + left < least) {
      break;
    }
  }
  return covered >= least;
}

bool PlacePolicy::IsNewPlace(const NearbyPlace& here,
                             const KeyframeFeatures& seen,
                             const std::vector<NearbyPlace>& places) const {
  if (spacing_m_ >= 0) {
    return spacing_m_ == 0 || std::all_of(places.begin(), places.end(), [&](const auto& place) {
             return IsSpacedFrom(place, here);
           });
  }
  const Points points = Sample(seen);
  return std::none_of(places.begin(), places.end(), [&](const NearbyPlace& place) {
    return Covers(place.T_M_C.Inverse() * here.T_M_C, points);
  });
}

}  // namespace deja_view
