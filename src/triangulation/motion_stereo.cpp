#include "deja_view/triangulation/motion_stereo.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/features/keypoint_grid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deja_view {
namespace {

// Baselines over depth that are looked for beside that of the newest image: a short one is matched
// with ease, a long one measures well.
constexpr double kBestParallax[] = {0.06, 0.15, 0.1, 0.25};
constexpr double kMinParallax = 0.01;
constexpr double kMaxParallax = 0.7;

}  // namespace

std::vector<std::string> MotionStereoOptions::Validate() const {
  Requirements r;
  r.That(recent >= 0, "recent", recent, "at least 0");
  r.That(partners >= 1, "partners", partners, "at least 1");
  r.Range("min_overlap", min_overlap, 0.0, 1.0);
  r.Range("min_depth_ratio", min_depth_ratio, 0.0, 1.0);
  r.That(enough >= 0, "enough", enough, "at least 0");
  r.That(max_points >= 0, "max_points", max_points, "at least 0");
  r.That(min_distance_px >= 0, "min_distance_px", min_distance_px, "at least 0");
  r.That(position_sigma_per_sqrt_m >= 0,
         "position_sigma_per_sqrt_m",
         position_sigma_per_sqrt_m,
         "at least 0");
  r.That(yaw_sigma_per_sqrt_m_deg >= 0,
         "yaw_sigma_per_sqrt_m_deg",
         yaw_sigma_per_sqrt_m_deg,
         "at least 0");
  r.Group("pair", pair.Validate());
  return r.errors();
}

std::vector<std::size_t> SelectPoints(const CornerView& view,
                                      const std::vector<Eigen::Vector2f>& taken,
                                      const Camera& camera,
                                      const MotionStereoOptions& options) {
  constexpr float kGridCellPx = 32.0F;
  constexpr std::int32_t kManyMatches = 3;  // more of them say no more
  const KeypointGrid grid(taken, camera.width(), camera.height(), kGridCellPx);
  std::vector<std::pair<float, std::size_t>> order;
  for (std::size_t i = 0; i < view.depths.size(); ++i) {
    const InverseDepth& depth = view.depths[i];
    bool is_taken = !IsCertain(depth, options.pair);
    if (!is_taken) {
      grid.ForEachNear(view.pixels[i], static_cast<float>(options.min_distance_px), [&](int) {
        is_taken = true;
      });
    }
    if (!is_taken) {
      const auto matches = static_cast<float>(std::min(depth.matches, kManyMatches));
      order.emplace_back(depth.sigma / (depth.mean * matches), i);
    }
  }
  const auto count = std::min(order.size(), static_cast<std::size_t>(options.max_points));
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end());
  std::vector<std::size_t> selected;
  for (std::size_t k = 0; k < count; ++k) {
    selected.push_back(order[k].second);
  }
  return selected;
}

MotionStereo::MotionStereo(const MotionStereoOptions& options, std::shared_ptr<const Camera> camera)
    : options_(options), camera_(std::move(camera)) {
  DEJA_VIEW_CHECK(camera_ != nullptr);
  CheckNone(options_.Validate(), "motion stereo options");
  constexpr int kProbes = 5;
  for (int y = 0; y < kProbes; ++y) {
    for (int x = 0; x < kProbes; ++x) {
      probes_.push_back(camera_->Unproject(
          {(x + 0.5) * camera_->width() / kProbes, (y + 0.5) * camera_->height() / kProbes}));
    }
  }
}

double MotionStereo::Overlap(const Rigid3& T_b_a, double depth_m) const {
  int seen = 0;
  for (const Eigen::Vector3d& probe : probes_) {
    const auto pixel = camera_->Project(T_b_a * (depth_m * probe));
    seen += pixel && camera_->IsInImage(*pixel) ? 1 : 0;
  }
  return static_cast<double>(seen) / static_cast<double>(probes_.size());
}

double MotionStereo::MedianDepth(double otherwise) const {
  std::vector<double> depths;
  if (!recent_.empty()) {
    for (const InverseDepth& depth : recent_.back().view.depths) {
      if (IsCertain(depth, options_.pair)) {
        depths.push_back(1.0 / depth.mean);
      }
    }
  }
  constexpr std::size_t kEnough = 20;
  if (depths.size() < kEnough) {
    return otherwise;
  }
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

std::vector<MotionStereo::Partner> MotionStereo::ChoosePartners(const Image& image,
                                                                double depth_m) const {
  std::vector<Partner> usable;
  for (std::size_t i = recent_.size(); i-- > 0;) {
    if (image.wanted <= 0 && recent_[i].wanted <= 0) {
      continue;
    }
    const Rigid3 T_b_a = recent_[i].T_W_C.Inverse() * image.T_W_C;
    const double parallax = T_b_a.t.norm() / depth_m;
    if (parallax >= kMinParallax && parallax <= kMaxParallax &&
        Overlap(T_b_a, depth_m) >= options_.min_overlap) {
      usable.push_back({i, parallax});
    }
  }
  std::vector<Partner> chosen;
  const auto count = std::min(usable.size(), static_cast<std::size_t>(options_.partners));
  for (std::size_t k = 0; chosen.size() < count; ++k) {
    // The newest, then those of the best parallaxes.
    const double best = kBestParallax[std::min<std::size_t>(k, 4) - (k > 0 ? 1 : 0)];
    const auto cost = [&](const Partner& p) {
      return k == 0 ? 0.0 : std::abs(std::log(p.parallax / best));
    };
    const auto it =
        std::min_element(usable.begin(), usable.end(), [&](const Partner& a, const Partner& b) {
          return cost(a) < cost(b);
        });
    chosen.push_back(*it);
    usable.erase(it);
  }
  std::stable_sort(chosen.begin(), chosen.end(), [](const Partner& a, const Partner& b) {
    return a.parallax < b.parallax;
  });
  return chosen;
}

std::vector<const MotionStereo::Image*> MotionStereo::Add(
    int id, const Rigid3& T_W_C, CornerView view, std::size_t tracked, double depth_m) {
  while (recent_.size() > static_cast<std::size_t>(std::max(0, options_.recent))) {
    recent_.pop_front();
  }
  const bool has_enough = tracked >= static_cast<std::size_t>(options_.enough);
  Image image{id, T_W_C, std::move(view), has_enough ? 0 : options_.partners};
  std::vector<std::size_t> changed;
  const double median_m = MedianDepth(depth_m);
  TriangulationOptions pair = options_.pair;
  pair.min_depth_m = std::max(pair.min_depth_m, options_.min_depth_ratio * median_m);
  for (const Partner& partner : ChoosePartners(image, median_m)) {
    Image& other = recent_[partner.index];
    const Rigid3 T_b_a = other.T_W_C.Inverse() * T_W_C;
    const double root = std::sqrt(T_b_a.t.norm());
    const PoseNoise noise{options_.position_sigma_per_sqrt_m * root,
                          ToRadians(options_.yaw_sigma_per_sqrt_m_deg) * root};
    if (TriangulatePair(T_b_a, noise, *camera_, pair, &image.view, &other.view) > 0) {
      changed.push_back(partner.index);
      --image.wanted;
      --other.wanted;
    }
  }
  recent_.push_back(std::move(image));
  std::vector<const Image*> result = {&recent_.back()};
  for (const std::size_t i : changed) {
    result.push_back(&recent_[i]);
  }
  return result;
}

}  // namespace deja_view
