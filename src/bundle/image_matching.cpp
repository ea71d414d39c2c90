#include "image_matching.hpp"

#include "deja_view/base/parallel.hpp"
#include "deja_view/features/hamming_matcher.hpp"
#include "deja_view/features/keypoint_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

namespace deja_view::internal {
namespace {

/// Joins the lists that each index made, in the order of the indices.
std::vector<KeypointMatch> Join(std::vector<std::vector<KeypointMatch>> lists) {
  std::vector<KeypointMatch> all;
  for (const std::vector<KeypointMatch>& list : lists) {
    all.insert(all.end(), list.begin(), list.end());
  }
  return all;
}

std::vector<KeypointMatch> MatchPair(const BundleOptions& options,
                                     const BundleProblem& problem,
                                     int a,
                                     int b) {
  const std::vector<Descriptor>& in_a = problem.images[static_cast<std::size_t>(a)].descriptors;
  const std::vector<Descriptor>& in_b = problem.images[static_cast<std::size_t>(b)].descriptors;
  const std::vector<HammingMatch> forward = MatchHamming(in_a, in_b, options.max_hamming);
  const std::vector<HammingMatch> backward = MatchHamming(in_b, in_a, options.max_hamming);
  std::vector<KeypointMatch> matches;
  for (std::size_t i = 0; i < forward.size(); ++i) {
    const HammingMatch& m = forward[i];
    if (m.best >= 0 && backward[static_cast<std::size_t>(m.best)].best == static_cast<int>(i) &&
        (m.second < 0 || m.best_distance <= options.max_hamming_ratio * m.second_distance)) {
      matches.push_back({{a, static_cast<int>(i)}, {b, m.best}, m.best_distance});
    }
  }
  return matches;
}

/// Distance of a ray of b from the epipolar plane of a ray of a [rad], or between the rays where
/// that is less.
double EpipolarAngle(const Rigid3& T_a_b,
                     const Eigen::Vector3d& ray_a,
                     const Eigen::Vector3d& ray_b) {
  const Eigen::Vector3d turned = T_a_b.q * ray_b;
  const double between = turned.cross(ray_a).norm();
  const Eigen::Vector3d normal = T_a_b.t.cross(ray_a);
  const double length = normal.norm();
  return length > 0 ? std::min(between, std::abs(normal.dot(turned)) / length) : between;
}

/// A point in an image that does not see it yet.
struct Projected {
  int point = -1;
  BundleObservation source;  ///< the keypoint seen from the nearest direction
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
};

std::optional<Projected> ProjectInto(const BundleProblem& problem,
                                     const std::vector<Rigid3>& T_W_C,
                                     int image,
                                     int point_index) {
  // A descriptor is recognised up to about this change of scale and of viewing direction.
  constexpr double kMaxScale = 1.6;
  constexpr double kMinCosine = 0.77;  // 40 degrees
  const BundlePoint& point = problem.points[static_cast<std::size_t>(point_index)];
  const BundleImage& target = problem.images[static_cast<std::size_t>(image)];
  const Camera& camera = *problem.cameras[static_cast<std::size_t>(target.camera)].camera;
  const Rigid3& T = T_W_C[static_cast<std::size_t>(image)];
  const auto pixel = camera.Project(T.q.conjugate() * (point.p_W - T.t));
  if (!pixel || !camera.IsInImage(*pixel)) {
    return std::nullopt;
  }
  const Eigen::Vector3d sight = point.p_W - T.t;
  double best = kMinCosine;
  std::optional<Projected> result;
  for (const BundleObservation& o : point.observations) {
    if (o.image == image) {
      return std::nullopt;
    }
    const Eigen::Vector3d other = point.p_W - T_W_C[static_cast<std::size_t>(o.image)].t;
    const double scale = other.norm() / sight.norm();
    const double cosine = other.dot(sight) / (other.norm() * sight.norm());
    if (cosine > best && scale < kMaxScale && scale > 1 / kMaxScale) {
      best = cosine;
      result = Projected{point_index, o, pixel->cast<float>()};
    }
  }
  return result;
}

std::optional<KeypointMatch> FindNear(const BundleOptions& options,
                                      const BundleProblem& problem,
                                      const KeypointGrid& grid,
                                      int image,
                                      const Projected& projected,
                                      double radius_px) {
  const BundleImage& target = problem.images[static_cast<std::size_t>(image)];
  const Descriptor& descriptor =
      problem.images[static_cast<std::size_t>(projected.source.image)]
          .descriptors[static_cast<std::size_t>(projected.source.keypoint)];
  int best = -1;
  int distance = options.max_hamming + 1;
  int second = 257;
  grid.ForEachNear(projected.pixel, static_cast<float>(radius_px), [&](int k) {
    const int d = HammingDistance(descriptor, target.descriptors[static_cast<std::size_t>(k)]);
    if (d < distance) {
      second = distance;
      distance = d;
      best = k;
    } else {
      second = std::min(second, d);
    }
  });
  if (best < 0 || distance > options.max_hamming_ratio * second) {
    return std::nullopt;
  }
  return KeypointMatch{projected.source, {image, best}, distance};
}

/// Points that each image sees.
std::vector<std::vector<int>> PointsOfImages(const BundleProblem& problem) {
  std::vector<std::vector<int>> points(problem.images.size());
  for (std::size_t p = 0; p < problem.points.size(); ++p) {
    for (const BundleObservation& o : problem.points[p].observations) {
      points[static_cast<std::size_t>(o.image)].push_back(static_cast<int>(p));
    }
  }
  return points;
}

/// Matches of some points in one image.
std::vector<KeypointMatch> SearchImage(const BundleOptions& options,
                                       const BundleProblem& problem,
                                       const std::vector<Rigid3>& T_W_C,
                                       int image,
                                       const std::vector<int>& points,
                                       double error_px) {
  constexpr float kCell_px = 16;
  const BundleImage& target = problem.images[static_cast<std::size_t>(image)];
  const Camera& camera = *problem.cameras[static_cast<std::size_t>(target.camera)].camera;
  const KeypointGrid grid(target.keypoints, camera.width(), camera.height(), kCell_px);
  std::vector<KeypointMatch> matches;
  for (const int point : points) {
    const auto projected = ProjectInto(problem, T_W_C, image, point);
    const auto match =
        projected ? FindNear(options, problem, grid, image, *projected, error_px) : std::nullopt;
    if (match) {
      matches.push_back(*match);
    }
  }
  return matches;
}

/// Relative poses of the loops' cameras, by (older, newer) image.
std::map<std::pair<int, int>, Rigid3> LoopsOfCameras(const BundleProblem& problem) {
  std::map<std::pair<int, int>, Rigid3> loops;
  const auto T_B_C = [&](int image) -> const Rigid3& {
    const int camera = problem.images[static_cast<std::size_t>(image)].camera;
    return problem.cameras[static_cast<std::size_t>(camera)].T_B_C;
  };
  for (const BundleLoop& loop : problem.loops) {
    const Rigid3 T = T_B_C(loop.from).Inverse() * loop.T_from_to * T_B_C(loop.to);
    loops[std::minmax(loop.from, loop.to)] = loop.from < loop.to ? T : T.Inverse();
  }
  return loops;
}

std::vector<Rigid3> CameraPoses(const BundleProblem& problem) {
  std::vector<Rigid3> poses;
  for (std::size_t i = 0; i < problem.images.size(); ++i) {
    poses.push_back(problem.CameraPose(static_cast<int>(i)));
  }
  return poses;
}

}  // namespace

std::vector<KeypointMatch> MatchDescriptors(const BundleOptions& options,
                                            const BundleProblem& problem,
                                            const std::vector<std::pair<int, int>>& pairs,
                                            const std::function<bool(double share)>& goes_on) {
  constexpr std::size_t kPairsAtOnce = 256;
  std::vector<std::vector<KeypointMatch>> matches(pairs.size());
  for (std::size_t first = 0; first < pairs.size(); first += kPairsAtOnce) {
    if (goes_on && !goes_on(static_cast<double>(first) / static_cast<double>(pairs.size()))) {
      break;
    }
    const std::size_t count = std::min(kPairsAtOnce, pairs.size() - first);
    ParallelFor(options.threads, count, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = first + begin; i < first + end; ++i) {
        matches[i] = MatchPair(options, problem, pairs[i].first, pairs[i].second);
      }
    });
  }
  return Join(std::move(matches));
}

ImageRays UnprojectKeypoints(const BundleProblem& problem, int threads) {
  ImageRays rays(problem.images.size());
  ParallelFor(threads, rays.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const BundleImage& image = problem.images[i];
      const Camera& camera = *problem.cameras[static_cast<std::size_t>(image.camera)].camera;
      for (const Eigen::Vector2f& keypoint : image.keypoints) {
        rays[i].push_back(camera.Unproject(keypoint.cast<double>()));
      }
    }
  });
  return rays;
}

std::vector<KeypointMatch> KeepEpipolar(const BundleOptions& options,
                                        const BundleProblem& problem,
                                        const ImageRays& rays,
                                        const std::vector<KeypointMatch>& matches,
                                        double error_px,
                                        bool use_loops) {
  const auto loops = use_loops ? LoopsOfCameras(problem) : std::map<std::pair<int, int>, Rigid3>();
  const std::vector<Rigid3> T_W_C = CameraPoses(problem);
  std::vector<char> is_kept(matches.size(), 0);
  ParallelFor(
      options.threads,
      matches.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const KeypointMatch& m = matches[i];
          const auto a = static_cast<std::size_t>(m.a.image);
          const auto b = static_cast<std::size_t>(m.b.image);
          const Eigen::Vector3d& ray_a = rays[a][static_cast<std::size_t>(m.a.keypoint)];
          const Eigen::Vector3d& ray_b = rays[b][static_cast<std::size_t>(m.b.keypoint)];
          const int camera = problem.images[b].camera;
          const double limit =
              error_px / problem.cameras[static_cast<std::size_t>(camera)].camera->FocalLength();
          bool fits = EpipolarAngle(T_W_C[a].Inverse() * T_W_C[b], ray_a, ray_b) < limit;
          const auto loop = fits ? loops.end() : loops.find({m.a.image, m.b.image});
          is_kept[i] =
              fits || (loop != loops.end() && EpipolarAngle(loop->second, ray_a, ray_b) < limit);
        }
      },
      1024);
  std::vector<KeypointMatch> kept;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (is_kept[i] != 0) {
      kept.push_back(matches[i]);
    }
  }
  return kept;
}

std::vector<KeypointMatch> SearchByProjection(const BundleOptions& options,
                                              const BundleProblem& problem,
                                              const std::vector<std::pair<int, int>>& pairs,
                                              double error_px) {
  const std::vector<std::vector<int>> seen = PointsOfImages(problem);
  std::vector<std::vector<int>> candidates(problem.images.size());
  const auto add = [&](int from, int to) {
    const std::vector<int>& points = seen[static_cast<std::size_t>(from)];
    std::vector<int>& all = candidates[static_cast<std::size_t>(to)];
    all.insert(all.end(), points.begin(), points.end());
  };
  for (const auto& [a, b] : pairs) {
    add(a, b);
    add(b, a);
  }
  const std::vector<Rigid3> T_W_C = CameraPoses(problem);
  std::vector<std::vector<KeypointMatch>> matches(problem.images.size());
  ParallelFor(options.threads, matches.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::vector<int>& points = candidates[i];
      std::sort(points.begin(), points.end());
      points.erase(std::unique(points.begin(), points.end()), points.end());
      matches[i] = SearchImage(options, problem, T_W_C, static_cast<int>(i), points, error_px);
    }
  });
  return Join(std::move(matches));
}

}  // namespace deja_view::internal
