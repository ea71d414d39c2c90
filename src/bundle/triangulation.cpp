#include "triangulation.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include <Eigen/Cholesky>

namespace deja_view::internal {
namespace {

/// One observation as it looks from W.
struct View {
  BundleObservation observation;
  Rigid3 T_C_W;
  Eigen::Vector3d centre_W;
  Eigen::Vector3d ray_W;
  Eigen::Vector2d pixel;
  const Camera* camera = nullptr;
};

double ErrorPx(const View& view, const Eigen::Vector3d& p_W) {
  const auto pixel = view.camera->Project(view.T_C_W * p_W);
  return pixel ? (*pixel - view.pixel).norm() : std::numeric_limits<double>::infinity();
}

/// Angles to rays, nearly: squared distances from the rays over those from the cameras; two rounds.
std::optional<Eigen::Vector3d> Intersect(const std::vector<const View*>& views) {
  constexpr int kRounds = 2;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (const View* view : views) {
      const double weight =
          round == 0 ? 1.0 : 1.0 / std::max(1e-6, (p - view->centre_W).squaredNorm());
      const Eigen::Matrix3d across =
          weight * (Eigen::Matrix3d::Identity() - view->ray_W * view->ray_W.transpose());
      A += across;
      b += across * view->centre_W;
    }
    p = A.ldlt().solve(b);
    if (!p.allFinite()) {
      return std::nullopt;
    }
  }
  return p;
}

double Parallax(const std::vector<const View*>& views, const Eigen::Vector3d& p_W) {
  double cosine = 1;
  std::vector<Eigen::Vector3d> sights;
  for (const View* view : views) {
    sights.push_back((p_W - view->centre_W).normalized());
    for (const Eigen::Vector3d& other : sights) {
      cosine = std::min(cosine, sights.back().dot(other));
    }
  }
  return std::acos(std::max(-1.0, cosine));
}

std::vector<const View*> Agreeing(const std::vector<const View*>& views,
                                  const Eigen::Vector3d& p_W,
                                  double error_px) {
  std::vector<const View*> agreeing;
  std::copy_if(views.begin(), views.end(), std::back_inserter(agreeing), [&](const View* view) {
    return ErrorPx(*view, p_W) < error_px;
  });
  return agreeing;
}

/// The views that agree on the best point that two of them make.
std::vector<const View*> LargestConsensus(const std::vector<const View*>& views, double error_px) {
  constexpr std::size_t kMaxTries = 40;
  const std::size_t n = views.size();
  const std::size_t pairs = n * (n - 1) / 2;
  const std::size_t stride = std::max<std::size_t>(1, pairs / kMaxTries);
  std::vector<const View*> best;
  std::size_t index = 0;
  for (std::size_t gap = n - 1; gap >= 1; --gap) {  // the widest apart first
    for (std::size_t i = 0; i + gap < n; ++i) {
      if (index++ % stride != 0) {
        continue;
      }
      const auto p = Intersect({views[i], views[i + gap]});
      auto agreeing = p ? Agreeing(views, *p, error_px) : std::vector<const View*>{};
      if (agreeing.size() > best.size()) {
        best = std::move(agreeing);
      }
    }
  }
  return best;
}

class TrackTriangulator {
 public:
  TrackTriangulator(const BundleOptions& options, double error_px)
      : options_(options), error_px_(error_px) {}

  /// Appends up to two points.
  void Triangulate(const std::vector<View>& views, std::vector<BundlePoint>* points) const {
    constexpr int kMaxPoints = 2;
    std::vector<const View*> left;
    for (const View& view : views) {
      left.push_back(&view);
    }
    for (int i = 0; i < kMaxPoints && IsEnough(left); ++i) {
      std::vector<const View*> used = FindPoint(left, points);
      if (used.empty()) {
        return;
      }
      std::vector<const View*> rest;
      std::set_difference(
          left.begin(), left.end(), used.begin(), used.end(), std::back_inserter(rest));
      left = std::move(rest);
    }
  }

 private:
  bool IsEnough(const std::vector<const View*>& views) const {
    return views.size() >= static_cast<std::size_t>(options_.min_views);
  }

  /// Views that a new point explains; none, and no point, where too few agree.
  std::vector<const View*> FindPoint(const std::vector<const View*>& views,
                                     std::vector<BundlePoint>* points) const {
    auto p = Intersect(views);
    std::vector<const View*> agreeing = p ? Agreeing(views, *p, error_px_) : views;
    if (!p || agreeing.size() < views.size()) {
      agreeing = LargestConsensus(views, error_px_);
      if (!IsEnough(agreeing)) {
        return {};
      }
      p = Intersect(agreeing);
      agreeing = p ? Agreeing(views, *p, error_px_) : std::vector<const View*>{};
    }
    if (!IsEnough(agreeing)) {
      return {};
    }
    const double parallax = Parallax(agreeing, *p);
    if (parallax < ToRadians(options_.min_parallax_deg)) {
      return {};
    }
    BundlePoint point;
    point.p_W = *p;
    point.parallax_rad = parallax;
    for (const View* view : agreeing) {
      point.observations.push_back(view->observation);
    }
    points->push_back(std::move(point));
    return agreeing;
  }

  const BundleOptions& options_;
  double error_px_;
};

View MakeView(const BundleProblem& problem,
              const std::vector<Rigid3>& T_W_C,
              const ImageRays& rays,
              const BundleObservation& o) {
  const auto i = static_cast<std::size_t>(o.image);
  const auto k = static_cast<std::size_t>(o.keypoint);
  const BundleImage& image = problem.images[i];
  return {o,
          T_W_C[i].Inverse(),
          T_W_C[i].t,
          T_W_C[i].q * rays[i][k],
          image.keypoints[k].cast<double>(),
          problem.cameras[static_cast<std::size_t>(image.camera)].camera.get()};
}

}  // namespace

std::vector<BundlePoint> Triangulate(const BundleOptions& options,
                                     const BundleProblem& problem,
                                     const ImageRays& rays,
                                     const std::vector<Track>& tracks,
                                     double error_px) {
  std::vector<Rigid3> T_W_C;
  for (std::size_t i = 0; i < problem.images.size(); ++i) {
    T_W_C.push_back(problem.CameraPose(static_cast<int>(i)));
  }
  const TrackTriangulator triangulator(options, error_px);
  std::vector<std::vector<BundlePoint>> found(tracks.size());
  ParallelFor(
      options.threads,
      tracks.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          std::vector<View> views;
          for (const BundleObservation& o : tracks[i]) {
            views.push_back(MakeView(problem, T_W_C, rays, o));
          }
          triangulator.Triangulate(views, &found[i]);
        }
      },
      64);
  std::vector<BundlePoint> points;
  for (std::vector<BundlePoint>& of_track : found) {
    std::move(of_track.begin(), of_track.end(), std::back_inserter(points));
  }
  return points;
}

std::vector<double> ReprojectionErrors(const BundleProblem& problem, const BundlePoint& point) {
  std::vector<double> errors;
  for (const BundleObservation& o : point.observations) {
    const BundleImage& image = problem.images[static_cast<std::size_t>(o.image)];
    const Camera& camera = *problem.cameras[static_cast<std::size_t>(image.camera)].camera;
    const auto pixel = camera.Project(problem.CameraPose(o.image).Inverse() * point.p_W);
    const auto k = static_cast<std::size_t>(o.keypoint);
    errors.push_back(pixel ? (*pixel - image.keypoints[k].cast<double>()).norm()
                           : std::numeric_limits<double>::infinity());
  }
  return errors;
}

}  // namespace deja_view::internal
