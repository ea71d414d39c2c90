// The relative pose of a rig from matches with outliers: ours, and OpenGV's where it is installed.
// One thread. Arguments: cameras, radius of the rig [cm], pixel noise [0.1 px], outliers [%], error
// of VIO's roll and pitch [0.1 degrees]. Counters: share of scenes solved within 10 cm and 1
// degree, and the median errors.
#include <algorithm>
#include <cmath>
#include <vector>

#include "rig_pose_scene.hpp"
#include <benchmark/benchmark.h>

#ifdef DEJA_VIEW_HAS_OPENGV
#include "opengv_rig_pose.hpp"
#endif

namespace deja_view {
namespace {

constexpr int kScenes = 100;
constexpr double kFocal = test::kRigFocalPx;
constexpr double kDegree = 3.14159265358979323846 / 180.0;

using test::RigPoseScene;

RefinedPose RefineOurs(const RigPoseScene& scene, const RansacResult& ransac, bool use_gravity) {
  std::vector<PointObservation> supported;
  for (const int i : ransac.inliers) {
    supported.push_back(scene.observations[static_cast<std::size_t>(i)]);
  }
  return RefineRelativePose(ransac.T_O_U, supported, scene.gravity, use_gravity, kFocal, {});
}

struct TwoPoint {
  static Rigid3 Solve(const RigPoseScene& scene) {
    return EstimateRelativePose(scene.observations, scene.gravity, kFocal, {}).T_O_U;
  }
};

struct TwoPointRefined {
  static Rigid3 Solve(const RigPoseScene& scene) {
    const auto ransac = EstimateRelativePose(scene.observations, scene.gravity, kFocal, {});
    return RefineOurs(scene, ransac, true).T_O_U;
  }
};

#ifdef DEJA_VIEW_HAS_OPENGV
constexpr int kMaxIterations = 1000;  // three points need more than the 300 that two take

struct Gp3p {
  static Rigid3 Solve(const RigPoseScene& scene) {
    return test::OpengvRigPose(scene.observations).Ransac(kFocal, {}, kMaxIterations).T_O_U;
  }
};

struct Gp3pRefined {
  static Rigid3 Solve(const RigPoseScene& scene) {
    test::OpengvRigPose opengv(scene.observations);
    const RansacResult ransac = opengv.Ransac(kFocal, {}, kMaxIterations);
    return ransac.inliers.size() < 4 ? ransac.T_O_U : opengv.Refine(ransac.T_O_U, ransac.inliers);
  }
};

struct Gp3pThenGpnp {
  static Rigid3 Solve(const RigPoseScene& scene) {
    test::OpengvRigPose opengv(scene.observations);
    const RansacResult ransac = opengv.Ransac(kFocal, {}, kMaxIterations);
    return ransac.inliers.size() < 6 ? ransac.T_O_U : opengv.Gpnp(ransac.inliers);
  }
};

struct Gp3pRefinedByOurs {
  static Rigid3 Solve(const RigPoseScene& scene) {
    test::OpengvRigPose opengv(scene.observations);
    return RefineOurs(scene, opengv.Ransac(kFocal, {}, kMaxIterations), true).T_O_U;
  }
};
#endif

std::vector<RigPoseScene> MakeScenes(const benchmark::State& state) {
  test::RigPoseSceneOptions options;
  options.cameras = static_cast<int>(state.range(0));
  options.radius_m = static_cast<double>(state.range(1)) / 100.0;
  options.pixel_noise = static_cast<double>(state.range(2)) / 10.0;
  options.outlier_ratio = static_cast<double>(state.range(3)) / 100.0;
  options.tilt_noise_deg = static_cast<double>(state.range(4)) / 10.0;
  std::vector<RigPoseScene> scenes;
  for (int i = 0; i < kScenes; ++i) {
    options.seed = static_cast<std::uint32_t>(i + 1);
    scenes.push_back(test::MakeRigPoseScene(options));
  }
  return scenes;
}

template <typename Method>
void BM_RigPose(benchmark::State& state) {
  const std::vector<RigPoseScene> scenes = MakeScenes(state);
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(Method::Solve(scenes[next++ % scenes.size()]));
  }
  std::vector<double> metres;
  std::vector<double> degrees;
  int solved = 0;
  for (const RigPoseScene& scene : scenes) {
    const Rigid3 T = Method::Solve(scene);
    metres.push_back((T.t - scene.T_O_U.t).norm());
    degrees.push_back(RotationAngle(T.q.conjugate() * scene.T_O_U.q) / kDegree);
    solved += metres.back() < 0.1 && degrees.back() < 1.0;
  }
  const auto median = [](std::vector<double>* values) {
    std::nth_element(values->begin(), values->begin() + kScenes / 2, values->end());
    return (*values)[kScenes / 2];
  };
  state.counters["solved"] = static_cast<double>(solved) / kScenes;
  state.counters["cm"] = 100.0 * median(&metres);
  state.counters["deg"] = median(&degrees);
}

void Cases(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"cameras", "cm", "px/10", "outliers%", "deg/10"})
      ->Unit(benchmark::kMicrosecond);
  for (const int outliers : {20, 50, 70}) {
    for (const int noise : {5, 20}) {
      benchmark->Args({2, 2, noise, outliers, 2})->Args({5, 80, noise, outliers, 2});
    }
  }
  for (const int tilt : {0, 5, 10, 20}) {
    benchmark->Args({3, 30, 10, 50, tilt});
  }
}

BENCHMARK_TEMPLATE(BM_RigPose, TwoPoint)->Apply(Cases);
BENCHMARK_TEMPLATE(BM_RigPose, TwoPointRefined)->Apply(Cases);
#ifdef DEJA_VIEW_HAS_OPENGV
BENCHMARK_TEMPLATE(BM_RigPose, Gp3p)->Apply(Cases);
BENCHMARK_TEMPLATE(BM_RigPose, Gp3pRefined)->Apply(Cases);
BENCHMARK_TEMPLATE(BM_RigPose, Gp3pThenGpnp)->Apply(Cases);
BENCHMARK_TEMPLATE(BM_RigPose, Gp3pRefinedByOurs)->Apply(Cases);
#endif

}  // namespace
}  // namespace deja_view
