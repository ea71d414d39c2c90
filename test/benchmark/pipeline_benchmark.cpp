// Verification of a candidate pair and pose graph solves on synthetic data, one thread.
#include "deja_view/pose_graph/pose_graph.hpp"
#include "deja_view/verification/loop_verifier.hpp"

#include <cmath>
#include <random>

#include "keyframe_pair.hpp"
#include <benchmark/benchmark.h>

namespace deja_view {
namespace {

/// Two keyframes of one place, 1000 keypoints and 150 tracked points each.
void BM_Verify(benchmark::State& state) {
  test::KeyframePairOptions options;
  options.corners = 900;
  options.tracked = 150;
  options.recognised = static_cast<int>(state.range(0));
  test::KeyframePair pair = test::MakeKeyframePair(options);
  std::mt19937_64 rng(1);
  for (KeyframeFeatures* f : {&pair.old.features, &pair.current.features}) {
    while (f->keypoints.size() < 1000) {
      f->keypoints.emplace_back(static_cast<float>(rng() % 752), static_cast<float>(rng() % 480));
      f->descriptors.push_back(test::RandomDescriptor(&rng));
    }
  }
  const LoopVerifier verifier({}, pair.camera);
  Verification v;
  for (auto _ : state) {
    v = verifier.Verify(
        pair.current.features, pair.current.T_W_B.q, pair.old.features, pair.old.T_W_B.q);
    benchmark::DoNotOptimize(v);
  }
  state.SetLabel(EnumToString(v.reason));
  state.counters["inliers"] = v.inliers;
}
// Points that look alike in both images: a loop, a hard one (60 of the 150 tracked), another place.
BENCHMARK(BM_Verify)->Arg(900)->Arg(60)->Arg(0)->Unit(benchmark::kMicrosecond);

/// Rounds of a circle with drift, 0.3 m between nodes; one loop in eight is wrong.
PoseGraph MakeGraph(int nodes, int loops) {
  std::mt19937 rng(1);
  std::normal_distribution<double> normal;
  constexpr int kPerRound = 100;
  PoseGraph graph{PoseGraphOptions{}};
  std::vector<Rigid3> truth;
  Rigid3 drift;
  for (int i = 0; i < nodes; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / kPerRound;
    truth.push_back({FromYaw(angle), {5 * std::cos(angle), 5 * std::sin(angle), 1}});
    drift.q = FromYaw(Yaw(drift.q) + 0.001 * normal(rng));
    drift.t.x() += 0.005 * normal(rng);
    drift.t.y() += 0.005 * normal(rng);
    graph.AddNode(0, drift * truth.back());
  }
  for (int i = 0; i < loops; ++i) {
    PoseGraphLoop loop;
    loop.from = static_cast<int>(rng() % static_cast<unsigned>(nodes - kPerRound));
    loop.to = loop.from + kPerRound + static_cast<int>(rng() % 5U);
    loop.to = std::min(loop.to, nodes - 1);
    loop.T_from_to = truth[static_cast<std::size_t>(loop.from)].Inverse() *
                     truth[static_cast<std::size_t>(loop.to)];
    if (i % 8 == 0) {
      loop.T_from_to.t.x() += 1.0;
    }
    loop.covariance = Eigen::Matrix<double, 6, 6>::Identity() * 4e-4;
    graph.AddLoop(loop);
  }
  return graph;
}

void BM_SolvePoseGraph(benchmark::State& state) {
  const PoseGraph start =
      MakeGraph(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  PoseGraph::Summary summary;
  for (auto _ : state) {
    PoseGraph graph = start;
    summary = graph.Solve();
    benchmark::DoNotOptimize(graph);
  }
  state.counters["rounds"] = summary.rounds;
  state.counters["iterations"] = summary.iterations;
}
BENCHMARK(BM_SolvePoseGraph)
    ->Args({1000, 100})
    ->Args({1000, 1000})
    ->Args({4000, 1000})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace deja_view
