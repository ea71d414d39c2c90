#include "deja_view/triangulation/corner_depths.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/features/keypoint_grid.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace deja_view {
namespace {

constexpr float kGridCellPx = 16.0F;
constexpr double kGateSigmas = 3.0;

/// A corner of the other view, the nearest by descriptor, and how near the next one is that lies
/// elsewhere.
struct Nearest {
  int index = -1;
  int distance = 257;
  int second = 257;
};

/// From a to b, with what a search needs of both.
struct Pair {
  Eigen::Matrix3d R_b_a;
  Eigen::Vector3d t_b_a;
  Eigen::Vector3d b_in_a;  ///< centre of b
  PoseNoise noise;
  double focal;
};

/// Range of inverse depths that a corner may have.
struct Range {
  double low;
  double high;
};

Range RangeOf(const InverseDepth& depth, const TriangulationOptions& options) {
  Range range{1.0 / options.max_depth_m, 1.0 / options.min_depth_m};
  if (depth.is_known()) {
    const double reach = kGateSigmas * depth.sigma;
    range.low = std::max(range.low, depth.mean - reach);
    range.high = std::min(range.high, depth.mean + reach);
  }
  return range;
}

/// Walks along the image of a ray in b and compares with the corners beside it.
class CurveSearch {
 public:
  CurveSearch(const Pair& pair,
              const CornerView& b,
              const Camera& camera,
              const TriangulationOptions& options)
      : pair_(pair),
        b_(b),
        camera_(camera),
        options_(options),
        grid_(b.pixels, camera.width(), camera.height(), kGridCellPx) {}

  Nearest Find(const Eigen::Vector3d& ray, const Descriptor& descriptor, const Range& range) const {
    Nearest nearest;
    const Eigen::Vector3d far = pair_.R_b_a * ray;
    const auto pixel_at = [&](double inverse) {
      return camera_.Project(far + inverse * pair_.t_b_a);
    };
    auto from = pixel_at(range.low);
    const auto end = pixel_at(range.high);
    if (!from) {
      return nearest;
    }
    const double length = end ? std::min((*end - *from).norm(), kLongestPx) : kLongestPx;
    const int steps = static_cast<int>(length / kStepPx) + 1;
    for (int i = 1; i <= steps; ++i) {
      const auto to = pixel_at(range.low + (range.high - range.low) * i / steps);
      if (!to) {
        break;
      }
      Look(from->cast<float>(), to->cast<float>(), Band(range), descriptor, &nearest);
      from = to;
    }
    return nearest;
  }

 private:
  static constexpr double kLongestPx = 500.0;
  static constexpr double kStepPx = 12.0;  // the curve is straight that far

  float Band(const Range& range) const {
    const double angle = std::hypot(pair_.noise.rotation_rad, pair_.noise.position_m * range.low);
    return static_cast<float>(options_.band_px + 2.0 * angle * pair_.focal);
  }

  /// Compares with the corners within `band` of the segment.
  void Look(const Eigen::Vector2f& from,
            const Eigen::Vector2f& to,
            float band,
            const Descriptor& descriptor,
            Nearest* nearest) const {
    const Eigen::Vector2f along = to - from;
    const float length_squared = std::max(1e-6F, along.squaredNorm());
    const float reach = 0.5F * std::sqrt(length_squared) + band;
    grid_.ForEachNear(0.5F * (from + to), reach, [&](int i) {
      const Eigen::Vector2f offset = b_.pixels[static_cast<std::size_t>(i)] - from;
      const float u = std::clamp(offset.dot(along) / length_squared, 0.0F, 1.0F);
      if (i != nearest->index && (offset - u * along).squaredNorm() <= band * band) {
        Compare(i, descriptor, nearest);
      }
    });
  }

  void Compare(int i, const Descriptor& descriptor, Nearest* nearest) const {
    const int distance = HammingDistance(descriptor, b_.descriptors[static_cast<std::size_t>(i)]);
    const bool is_apart = AreApart(i, nearest->index);
    if (distance < nearest->distance) {
      nearest->second = is_apart ? nearest->distance : nearest->second;
      nearest->distance = distance;
      nearest->index = i;
    } else if (distance < nearest->second && is_apart) {
      nearest->second = distance;
    }
  }

  // Neighbours on one edge look alike and say nearly the same depth.
  bool AreApart(int i, int j) const {
    constexpr float kApartPx = 4.0F;
    return j < 0 ||
           (b_.pixels[static_cast<std::size_t>(i)] - b_.pixels[static_cast<std::size_t>(j)])
                   .squaredNorm() > kApartPx * kApartPx;
  }

  const Pair& pair_;
  const CornerView& b_;
  const Camera& camera_;
  const TriangulationOptions& options_;
  KeypointGrid grid_;
};

/// Measured inverse depth along `ray`, from the centre of the other camera and the direction from
/// there, all in one frame. Nothing for rays that diverge.
std::optional<InverseDepth> Triangulate(const Eigen::Vector3d& ray,
                                        const Eigen::Vector3d& other_centre,
                                        const Eigen::Vector3d& other_ray,
                                        const Pair& pair,
                                        const TriangulationOptions& options) {
  const Eigen::Vector3d normal = ray.cross(other_ray);
  const double sine_squared = normal.squaredNorm();
  const double along = other_centre.cross(other_ray).dot(normal);  // depth times the sine squared
  if (sine_squared < 1e-8 || along <= 0) {
    return std::nullopt;
  }
  const double inverse = sine_squared / along;
  const double angle_sigma =
      std::hypot(std::sqrt(2.0) * options.pixel_sigma / pair.focal,
                 std::hypot(pair.noise.rotation_rad, pair.noise.position_m * inverse));
  const double ratio = std::hypot(options.sigma_floor, angle_sigma / std::sqrt(sine_squared));
  return InverseDepth{static_cast<float>(inverse), static_cast<float>(inverse * ratio), 1};
}

bool Agree(const InverseDepth& a, const InverseDepth& b) {
  return !a.is_known() || !b.is_known() ||
         std::abs(a.mean - b.mean) < kGateSigmas * std::hypot(a.sigma, b.sigma);
}

InverseDepth Fuse(const InverseDepth& a, const InverseDepth& b, double sigma_floor) {
  if (!a.is_known() || !b.is_known()) {
    return a.is_known() ? a : b;
  }
  const double wa = 1.0 / (static_cast<double>(a.sigma) * a.sigma);
  const double wb = 1.0 / (static_cast<double>(b.sigma) * b.sigma);
  const double mean = (wa * a.mean + wb * b.mean) / (wa + wb);
  const double sigma = std::max(1.0 / std::sqrt(wa + wb), sigma_floor * mean);
  return {static_cast<float>(mean), static_cast<float>(sigma), a.matches + b.matches};
}

/// The depth of b's corner as seen from a.
std::optional<InverseDepth> Transfer(const InverseDepth& depth,
                                     const Eigen::Vector3d& ray_b,
                                     const Pair& pair) {
  const Eigen::Vector3d p_a = pair.R_b_a.transpose() * (ray_b / depth.mean - pair.t_b_a);
  const double range = p_a.norm();
  const double sigma_m = std::hypot(depth.sigma / (static_cast<double>(depth.mean) * depth.mean),
                                    pair.noise.position_m);
  if (!(p_a.z() > 0) || depth.mean <= 0) {
    return std::nullopt;
  }
  return InverseDepth{static_cast<float>(1.0 / range),
                      static_cast<float>(sigma_m / (range * range)),
                      depth.matches};
}

bool IsInRange(const InverseDepth& depth, const TriangulationOptions& options) {
  // A depth that is uncertain may well be beyond: it is near enough to be a start.
  return depth.mean * options.min_depth_m < 1.0 &&
         (depth.mean + kGateSigmas * depth.sigma) * options.max_depth_m > 1.0;
}

/// Fuses what the corners i of a and j of b, seen as the same, say of each other's depth.
bool FusePair(const Pair& pair,
              std::size_t i,
              std::size_t j,
              const TriangulationOptions& options,
              CornerView* a,
              CornerView* b) {
  const Eigen::Vector3d ray_a = a->rays[i].cast<double>();
  const Eigen::Vector3d ray_b = b->rays[j].cast<double>();
  const Eigen::Matrix3d R_a_b = pair.R_b_a.transpose();
  const auto in_a = Triangulate(ray_a, pair.b_in_a, R_a_b * ray_b, pair, options);
  const auto in_b = Triangulate(ray_b, pair.t_b_a, pair.R_b_a * ray_a, pair, options);
  if (!in_a || !in_b || !IsInRange(*in_a, options) || !Agree(*in_a, a->depths[i]) ||
      !Agree(*in_b, b->depths[j])) {
    return false;
  }
  InverseDepth known = a->depths[i];
  if (!known.is_known() && b->depths[j].is_known()) {
    known = Transfer(b->depths[j], ray_b, pair).value_or(known);
  }
  a->depths[i] = Fuse(known, *in_a, options.sigma_floor);
  b->depths[j] = Fuse(b->depths[j], *in_b, options.sigma_floor);
  return true;
}

bool IsDistinct(const Nearest& nearest, const TriangulationOptions& options) {
  return nearest.index >= 0 && nearest.distance <= options.max_distance &&
         nearest.distance < options.max_ratio * nearest.second;
}

}  // namespace

std::vector<std::string> TriangulationOptions::Validate() const {
  Requirements r;
  r.That(min_depth_m > 0, "min_depth_m", min_depth_m, "more than 0");
  r.That(max_depth_m > min_depth_m, "max_depth_m", max_depth_m, "more than min_depth_m");
  r.That(band_px > 0, "band_px", band_px, "more than 0");
  r.Range("max_distance", max_distance, 1, 256);
  r.Range("max_ratio", max_ratio, 0.0, 1.0);
  r.That(pixel_sigma > 0, "pixel_sigma", pixel_sigma, "more than 0");
  r.That(sigma_floor > 0, "sigma_floor", sigma_floor, "more than 0");
  r.That(max_sigma_ratio > sigma_floor, "max_sigma_ratio", max_sigma_ratio, "more than the floor");
  return r.errors();
}

CornerView MakeCornerView(const std::vector<Eigen::Vector2f>& pixels,
                          const std::vector<Descriptor>& descriptors,
                          const Camera& camera) {
  DEJA_VIEW_CHECK_OP(pixels.size(), ==, descriptors.size());
  CornerView view{pixels, descriptors, {}, std::vector<InverseDepth>(pixels.size())};
  view.rays.reserve(pixels.size());
  for (const Eigen::Vector2f& pixel : pixels) {
    view.rays.push_back(camera.Unproject(pixel.cast<double>()).cast<float>());
  }
  return view;
}

int TriangulatePair(const Rigid3& T_b_a,
                    const PoseNoise& noise,
                    const Camera& camera,
                    const TriangulationOptions& options,
                    CornerView* a,
                    CornerView* b) {
  const Pair pair{T_b_a.R(), T_b_a.t, T_b_a.Inverse().t, noise, camera.FocalLength()};
  const CurveSearch search(pair, *b, camera, options);
  std::vector<Nearest> nearest(a->pixels.size());
  std::vector<int> best_of_b(b->pixels.size(), -1);
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    nearest[i] =
        search.Find(a->rays[i].cast<double>(), a->descriptors[i], RangeOf(a->depths[i], options));
    if (!IsDistinct(nearest[i], options)) {
      continue;
    }
    int& best = best_of_b[static_cast<std::size_t>(nearest[i].index)];
    if (best < 0 || nearest[i].distance < nearest[static_cast<std::size_t>(best)].distance) {
      best = static_cast<int>(i);
    }
  }
  int pairs = 0;
  for (std::size_t j = 0; j < best_of_b.size(); ++j) {
    if (best_of_b[j] >= 0) {
      pairs += FusePair(pair, static_cast<std::size_t>(best_of_b[j]), j, options, a, b) ? 1 : 0;
    }
  }
  return pairs;
}

bool IsCertain(const InverseDepth& depth, const TriangulationOptions& options) {
  return depth.is_known() && depth.mean > 0 && depth.sigma < options.max_sigma_ratio * depth.mean &&
         depth.mean * options.max_depth_m > 1.0;
}

}  // namespace deja_view
