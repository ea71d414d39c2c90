#include "deja_view/lab/sim/exact_views.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/camera/depth_image.hpp"
#include "deja_view/lab/sim/random.hpp"
#include "deja_view/lab/sim/world.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>

namespace deja_view::sim {
std::vector<std::string> ExactViewPresetNames() {
  return {"paper", "wide"};
}

ExactViewOptions MakeExactViewPreset(const std::string& name) {
  ExactViewOptions options;
  if (name == "paper") {
    options.count = 2;
    options.min_distance_m = 0.0;
    options.max_distance_m = 0.02;
    options.max_angle_deg = 1.0;
  } else if (name != "wide") {
    ThrowInputError("virtual views {}: expected paper or wide", name);
  }
  return options;
}

std::vector<Rigid3> SampleExactViewPoses(const World& world,
                                         const Rigid3& T_W_C,
                                         const ExactViewOptions& options,
                                         std::uint64_t seed) {
  constexpr int kTriesPerView = 40;
  Rng random(seed, 71);
  std::vector<Rigid3> poses;
  for (int tries = 0; tries < kTriesPerView * options.count; ++tries) {
    const Eigen::Vector3d direction(
        random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-1, 1));
    const double distance = random.Uniform(options.min_distance_m, options.max_distance_m);
    const double angle = ToRadians(options.max_angle_deg);
    const Eigen::Vector3d turn(random.Uniform(-angle, angle),
                               random.Uniform(-angle, angle),
                               random.Uniform(-angle / 3, angle / 3));
    if (direction.norm() > 1 || direction.norm() < 1e-3) {
      continue;  // uniform on the sphere
    }
    const Rigid3 T_C_V{ExpSo3(turn), distance * direction.normalized()};
    // The whole way must be free: what lies behind a shelf can't be known.
    const Eigen::Vector3d p_W = (T_W_C * T_C_V).t;
    if (world.Clearance(p_W) < std::min(options.clearance_m, world.Clearance(T_W_C.t))) {
      continue;
    }
    poses.push_back(T_C_V);
    if (static_cast<int>(poses.size()) == options.count) {
      break;
    }
  }
  return poses;
}

VirtualView RenderExactView(const Renderer& renderer,
                            std::shared_ptr<const Camera> camera,
                            const Rigid3& T_W_C,
                            const Rigid3& T_C_V,
                            const ExactViewOptions& options) {
  const Rigid3 T_W_V = T_W_C * T_C_V;
  const cv::Mat radiance = renderer.RenderRadiance(T_W_V);
  const double gain = options.target_level / std::max(1e-3, cv::mean(radiance)[0]);
  VirtualView view;
  view.T_C_V = T_C_V;
  view.camera = std::move(camera);
  view.image = ToneMap(radiance, gain, options.gamma);
  view.depth_mm = ToMillimetres(renderer.RenderRange(T_W_V));
  return view;
}

}  // namespace deja_view::sim
