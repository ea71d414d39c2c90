#include "deja_view/views/view_sampling.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/random.hpp"
#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/flann.hpp>

namespace deja_view {
namespace {

std::vector<Eigen::Vector3d> DrawBall(const SamplingOptions& options, Random* random) {
  std::vector<Eigen::Vector3d> points;
  // Half of a cube lies in its ball; a shell has less.
  for (int i = 0;
       i < 100 * options.candidates && static_cast<int>(points.size()) < options.candidates;
       ++i) {
    Eigen::Vector3d p;
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] = random->Uniform(-options.radius_m, options.radius_m);
    }
    const double distance = p.norm();
    if (distance <= options.radius_m && distance >= options.min_radius_m) {
      points.push_back(p);
    }
  }
  return points;
}

/// Keeps the points, in order, of which no earlier kept one is nearer than `spacing`.
std::vector<Eigen::Vector3d> Thin(const std::vector<Eigen::Vector3d>& points, double spacing) {
  if (points.empty() || spacing <= 0) {
    return points;
  }
  cv::Mat data(static_cast<int>(points.size()), 3, CV_32FC1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      data.at<float>(static_cast<int>(i), axis) = static_cast<float>(points[i][axis]);
    }
  }
  cv::flann::GenericIndex<cvflann::L2_Simple<float>> tree(data, cvflann::KDTreeSingleIndexParams());
  // The tree is in single precision: it finds candidates, exact distances decide.
  const auto radius_squared = static_cast<float>(1.01 * spacing * spacing);
  std::vector<bool> is_near(points.size(), false);
  std::vector<Eigen::Vector3d> kept;
  std::vector<int> indices(points.size());
  std::vector<float> distances(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_near[i]) {
      continue;
    }
    kept.push_back(points[i]);
    const std::vector<float> query(data.ptr<float>(static_cast<int>(i)),
                                   data.ptr<float>(static_cast<int>(i)) + 3);
    const int found = tree.radiusSearch(
        query, indices, distances, radius_squared, cvflann::SearchParams(-1, 0.0F, false));
    for (int k = 0; k < std::min(found, static_cast<int>(indices.size())); ++k) {
      const auto j = static_cast<std::size_t>(indices[static_cast<std::size_t>(k)]);
      is_near[j] = is_near[j] || (points[j] - points[i]).norm() < spacing;
    }
  }
  return kept;
}

double NearestDistance(const Eigen::Vector3d& p, const std::vector<Rigid3>& views) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Rigid3& view : views) {
    nearest = std::min(nearest, (view.t - p).norm());
  }
  return nearest;
}

bool IsApart(const Rigid3& a, const Rigid3& b, const SourceOptions& options) {
  return (a.t - b.t).norm() >= options.every_m ||
         (options.every_deg > 0 &&
          RotationAngle(a.q.conjugate() * b.q) >= options.every_deg * kDegree);
}

}  // namespace

std::vector<std::string> SourceOptions::Validate() const {
  Requirements r;
  r.Range("every_m", every_m, 0, 1e6);
  r.Range("every_deg", every_deg, 0, 180);
  return r.errors();
}

std::vector<std::string> SamplingOptions::Validate() const {
  Requirements r;
  r.Range("views", views, 0, 1000);
  r.That(radius_m > 0 && radius_m <= 100, "radius_m", radius_m, "more than 0, at most 100");
  r.That(min_radius_m >= 0 && min_radius_m < radius_m,
         "min_radius_m",
         min_radius_m,
         "0 or more, below radius_m");
  r.That(spacing_min_m >= 0 && spacing_min_m < spacing_max_m,
         "spacing_min_m",
         spacing_min_m,
         "0 or more, below spacing_max_m");
  r.That(std::isfinite(spacing_max_m), "spacing_max_m", spacing_max_m, "a finite number");
  r.Range("rotation_deg", rotation_deg, 0, 180);
  r.Range("candidates", candidates, 1, 100000);
  return r.errors();
}

bool SourceSelector::Take(const Rigid3& T_N_C) {
  const bool is_apart = std::all_of(taken_.begin(), taken_.end(), [&](const Rigid3& source) {
    return IsApart(T_N_C, source, options_);
  });
  if (is_apart) {
    if (options_.against == SourceSpacing::kPrevious) {
      taken_.clear();
    }
    taken_.push_back(T_N_C);
  }
  return is_apart;
}

std::vector<std::size_t> SelectSources(const std::vector<Rigid3>& T_N_C,
                                       const SourceOptions& options) {
  SourceSelector selector(options);
  std::vector<std::size_t> sources;
  for (std::size_t i = 0; i < T_N_C.size(); ++i) {
    if (selector.Take(T_N_C[i])) {
      sources.push_back(i);
    }
  }
  return sources;
}

// Eq. 6, as corrected: positions in a ball, and rotations that stay rotations.
std::vector<Rigid3> SampleViews(const SamplingOptions& options,
                                std::int64_t stamp_ns,
                                const std::function<bool(const Rigid3& T_C_V)>& accept) {
  DEJA_VIEW_CHECK(options.Validate().empty());
  Random mixer(options.seed ^ static_cast<std::uint64_t>(stamp_ns));
  Random random(mixer.Next());
  const std::vector<Eigen::Vector3d> points =
      Thin(DrawBall(options, &random), options.spacing_min_m);
  const double half = 0.5 * options.rotation_deg * kDegree;
  std::vector<Rigid3> views;
  for (const Eigen::Vector3d& p : points) {
    if (static_cast<int>(views.size()) >= options.views) {
      break;
    }
    Eigen::Vector3d w;
    for (int axis = 0; axis < 3; ++axis) {
      w[axis] = random.Uniform(-half, half);
    }
    const Rigid3 T_C_V{ExpSo3(w), p};
    const bool is_in_reach = views.empty() || NearestDistance(p, views) <= options.spacing_max_m;
    if (is_in_reach && (!accept || accept(T_C_V))) {
      views.push_back(T_C_V);
    }
  }
  return views;
}

}  // namespace deja_view
