#include "deja_view/nerf/sparse_points.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/parallel.hpp"
#include "deja_view/features/brief_extractor.hpp"
#include "deja_view/features/hamming_matcher.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace deja_view::nerf {
namespace {

constexpr double kCornerSigma_px = 0.5;  ///< of a corner's place

/// Corners of one image with their unit rays in N.
struct ViewFeatures {
  Features features;
  std::vector<Eigen::Vector3d> rays_N;
};

/// Range of a corner as one pair of images gives it.
struct PairRange {
  double range = 0;     ///< [m]
  double parallax = 0;  ///< [rad]; the wider, the surer
};

ViewFeatures Describe(const SparsePointOptions& options, const TrainingView& view) {
  cv::Mat grey = view.image;
  if (view.image.channels() == 3) {
    cv::cvtColor(view.image, grey, cv::COLOR_BGR2GRAY);
  }
  BriefOptions brief;
  brief.max_features = options.features;
  brief.fast_threshold = 10;
  ViewFeatures result;
  result.features = BriefExtractor(brief).Extract(grey);
  for (const Keypoint& keypoint : result.features.keypoints) {
    const Eigen::Vector2d pixel(static_cast<double>(keypoint.x), static_cast<double>(keypoint.y));
    result.rays_N.emplace_back(view.T_N_C.q * view.camera->Unproject(pixel));
  }
  return result;
}

// The nearest images that look the same way, ever farther apart, since a wide baseline measures
// better and a narrow one matches better.
std::vector<std::size_t> Neighbours(const SparsePointOptions& options,
                                    const std::vector<TrainingView>& views,
                                    std::size_t i) {
  const Eigen::Vector3d axis = views[i].T_N_C.q * Eigen::Vector3d::UnitZ();
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const double cosine = axis.dot(views[k].T_N_C.q * Eigen::Vector3d::UnitZ());
    const double distance = (views[k].T_N_C.t - views[i].T_N_C.t).norm();
    if (k != i && distance > 0 && cosine > std::cos(options.max_angle_deg * kDegree)) {
      near.emplace_back(distance, k);
    }
  }
  std::sort(near.begin(), near.end());
  std::vector<std::size_t> chosen;
  std::size_t step = 1;
  for (std::size_t at = 0;
       at < near.size() && chosen.size() < static_cast<std::size_t>(options.neighbours);
       at += step++) {
    chosen.push_back(near[at].second);
  }
  return chosen;
}

// Where the two rays pass each other nearest, as a range along the first; nothing where they are
// nearly parallel, meet behind a camera, or miss each other by more than `max_angle` from either.
std::optional<PairRange> Intersect(const Eigen::Vector3d& origin_a,
                                   const Eigen::Vector3d& ray_a,
                                   const Eigen::Vector3d& origin_b,
                                   const Eigen::Vector3d& ray_b,
                                   double min_parallax,
                                   double max_angle) {
  const double cosine = ray_a.dot(ray_b);
  const double sine2 = 1 - cosine * cosine;
  if (sine2 < min_parallax * min_parallax) {
    return std::nullopt;
  }
  const Eigen::Vector3d ab = origin_b - origin_a;
  const double along_a = ab.dot(ray_a);
  const double along_b = ab.dot(ray_b);
  const double a = (along_a - cosine * along_b) / sine2;
  const double b = (cosine * along_a - along_b) / sine2;
  if (a <= 0 || b <= 0) {
    return std::nullopt;
  }
  const double gap = (origin_a + a * ray_a - origin_b - b * ray_b).norm();
  if (gap > max_angle * std::min(a, b)) {
    return std::nullopt;
  }
  return PairRange{a, std::sqrt(sine2)};
}

// The range that most pairs agree on, weighted by their parallax; nothing where too few do or their
// parallax is too little against `pixel_angle`.
std::optional<double> Agree(const SparsePointOptions& options,
                            const std::vector<PairRange>& pairs,
                            double pixel_angle) {
  std::size_t best = 0;
  double range = 0;
  double information = 0;
  for (const PairRange& center : pairs) {
    std::size_t count = 0;
    double sum = 0;
    double weight = 0;
    for (const PairRange& pair : pairs) {
      if (std::abs(pair.range - center.range) < options.max_disagreement * center.range) {
        ++count;
        sum += pair.parallax * pair.parallax * pair.range;
        weight += pair.parallax * pair.parallax;
      }
    }
    if (count > best) {
      best = count;
      range = sum / weight;
      information = weight;
    }
  }
  const double sigma = kCornerSigma_px * pixel_angle / std::sqrt(std::max(1e-12, information));
  if (best < static_cast<std::size_t>(options.min_pairs) || sigma > options.max_sigma) {
    return std::nullopt;
  }
  return range;
}

std::vector<DepthPoint> PointsOf(const SparsePointOptions& options,
                                 const std::vector<TrainingView>& views,
                                 const std::vector<ViewFeatures>& features,
                                 std::size_t i) {
  const ViewFeatures& from = features[i];
  std::vector<std::vector<PairRange>> pairs(from.rays_N.size());
  const double pixel_angle = 1 / views[i].camera->FocalLength();
  for (const std::size_t k : Neighbours(options, views, i)) {
    const std::vector<HammingMatch> matches = MatchHamming(
        from.features.descriptors, features[k].features.descriptors, options.max_distance);
    for (std::size_t p = 0; p < matches.size(); ++p) {
      if (matches[p].best < 0) {
        continue;
      }
      const auto pair = Intersect(views[i].T_N_C.t,
                                  from.rays_N[p],
                                  views[k].T_N_C.t,
                                  features[k].rays_N[static_cast<std::size_t>(matches[p].best)],
                                  options.min_parallax_deg * kDegree,
                                  options.max_error_px * pixel_angle);
      if (pair) {
        pairs[p].push_back(*pair);
      }
    }
  }
  std::vector<DepthPoint> points;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if (const std::optional<double> range = Agree(options, pairs[p], pixel_angle)) {
      const Keypoint& at = from.features.keypoints[p];
      points.push_back({at.x, at.y, static_cast<float>(*range)});
    }
  }
  return points;
}

}  // namespace

std::size_t AddSparsePoints(const SparsePointOptions& options,
                            int threads,
                            std::vector<TrainingView>* views) {
  std::vector<ViewFeatures> features(views->size());
  ParallelFor(threads, views->size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      features[i] = Describe(options, (*views)[i]);
    }
  });
  std::vector<std::vector<DepthPoint>> points(views->size());
  ParallelFor(threads, views->size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      points[i] = PointsOf(options, *views, features, i);
    }
  });
  std::size_t added = 0;
  for (std::size_t i = 0; i < views->size(); ++i) {
    std::vector<DepthPoint>& to = (*views)[i].points;
    to.insert(to.end(), points[i].begin(), points[i].end());
    added += points[i].size();
  }
  return added;
}

}  // namespace deja_view::nerf
