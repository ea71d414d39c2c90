#include "deja_view/lab/evaluation/relocalisation.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace deja_view {
namespace {

constexpr double kMaxAngleDeg = 30.0;
constexpr double kMaxDistanceM = 1.5;

std::vector<RelocalisationBin> MakeBins(double step, int count) {
  std::vector<RelocalisationBin> bins;
  for (int i = 0; i < count; ++i) {
    bins.push_back({i * step, (i + 1) * step, 0, 0});
  }
  return bins;
}

void Count(double offset, bool is_found, std::vector<RelocalisationBin>* bins) {
  for (RelocalisationBin& bin : *bins) {
    if (offset >= bin.from && offset < bin.to) {
      ++bin.keyframes;
      bin.found += is_found ? 1 : 0;
    }
  }
}

}  // namespace

RelocalisationCurve MakeRelocalisationCurve(const std::vector<TrueKeyframe>& places,
                                            const std::vector<TrueKeyframe>& current,
                                            const std::vector<bool>& is_found,
                                            const Rigid3& T_B_C) {
  DEJA_VIEW_CHECK_OP(current.size(), ==, is_found.size());
  const Eigen::Vector3d axis = T_B_C.q * Eigen::Vector3d::UnitZ();
  RelocalisationCurve curve{MakeBins(0.5, 12), MakeBins(10.0, 9)};
  for (std::size_t i = 0; i < current.size(); ++i) {
    if (!current[i].T_truth_B) {
      continue;
    }
    const Rigid3& T_here = *current[i].T_truth_B;
    double nearest_m = std::numeric_limits<double>::infinity();
    double least_deg = std::numeric_limits<double>::infinity();
    for (const TrueKeyframe& place : places) {
      if (!place.T_truth_B) {
        continue;
      }
      const double distance_m = (T_here.t - place.T_truth_B->t).norm();
      const double cosine = (T_here.q * axis).dot(place.T_truth_B->q * axis);
      const double angle_deg = std::acos(std::clamp(cosine, -1.0, 1.0)) / kDegree;
      if (angle_deg < kMaxAngleDeg) {
        nearest_m = std::min(nearest_m, distance_m);
      }
      if (distance_m < kMaxDistanceM) {
        least_deg = std::min(least_deg, angle_deg);
      }
    }
    Count(nearest_m, is_found[i], &curve.by_distance);
    Count(least_deg, is_found[i], &curve.by_angle);
  }
  return curve;
}

}  // namespace deja_view
