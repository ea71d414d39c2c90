#pragma once

#include "deja_view/lab/report/run.hpp"

#include <cmath>
#include <cstdint>

namespace deja_view::report {

/// Stamp of keyframe `i` of ExampleRun.
inline std::int64_t ExampleStamp(int i) {
  return 1'000'000'000'000 + i * std::int64_t{500'000'000};
}

/// The true body pose: two rounds on a circle of 3 m radius, 20 s each, looking ahead.
inline Rigid3 ExampleTruth(std::int64_t stamp_ns) {
  const double angle =
      2 * 3.14159265358979 * 1e-9 * static_cast<double>(stamp_ns - ExampleStamp(0)) / 20.0;
  return {FromYaw(angle), {3 * std::cos(angle), 3 * std::sin(angle), 1}};
}

inline Trajectory ExampleGroundTruth() {
  Trajectory truth;
  for (int i = 0; i <= 800; ++i) {
    truth.stamps_ns.push_back(ExampleStamp(0) + i * std::int64_t{50'000'000});
    truth.poses.push_back(ExampleTruth(truth.stamps_ns.back()));
  }
  return truth;
}

inline LoopRecord ExampleLoop(int current, int old) {
  LoopRecord loop;
  loop.stamp_current_ns = ExampleStamp(current);
  loop.stamp_old_ns = ExampleStamp(old);
  loop.T_Bold_Bcurrent =
      ExampleTruth(loop.stamp_old_ns).Inverse() * ExampleTruth(loop.stamp_current_ns);
  loop.score = 0.5;
  loop.inliers = 40;
  loop.accepted = true;
  loop.reason = "accepted";
  return loop;
}

/// 81 keyframes over 40 s. The VIO drifts along z as well as aside, the corrected trajectory is the
/// truth in another frame. Keyframe 41 to 43 have a correct loop, keyframe 60 has a wrong one, and
/// a candidate of keyframe 70 was refused.
inline RunData ExampleRun() {
  RunData run;
  run.name = "example";
  const Rigid3 T_other_W = {FromYaw(0.7), {5, -2, 1}};
  for (int i = 0; i <= 80; ++i) {
    const Rigid3 T_W_B = ExampleTruth(ExampleStamp(i));
    run.corrected.stamps_ns.push_back(ExampleStamp(i));
    run.corrected.poses.push_back(T_other_W * T_W_B);
    run.vio.stamps_ns.push_back(ExampleStamp(i));
    run.vio.poses.push_back({T_W_B.q, T_W_B.t + Eigen::Vector3d(0.0002 * i * i, 0, 0.005 * i)});
  }
  run.loops = {ExampleLoop(41, 1), ExampleLoop(42, 2), ExampleLoop(43, 3)};
  run.loops.push_back(ExampleLoop(60, 20));
  run.loops.back().T_Bold_Bcurrent.t.x() += 1;
  run.loops.push_back(ExampleLoop(70, 30));
  run.loops.back().accepted = false;
  run.loops.back().reason = "too_few_inliers";
  return run;
}

}  // namespace deja_view::report
