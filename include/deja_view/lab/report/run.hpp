#pragma once

#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/geometry/trajectory.hpp"
#include "deja_view/lab/evaluation/ape.hpp"
#include "deja_view/lab/evaluation/judge.hpp"
#include "deja_view/lab/evaluation/loop_score.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace deja_view::report {

/// A row of loops.csv: a verified candidate, accepted or not.
struct LoopRecord {
  std::int64_t stamp_current_ns = 0;
  std::int64_t stamp_old_ns = 0;
  Rigid3 T_Bold_Bcurrent;  ///< [m]
  double score = 0;
  int inliers = 0;
  bool is_virtual = false;
  bool accepted = false;
  std::string reason;
};

/// What a replay or the node left in its output directory.
struct RunData {
  std::string name;
  Trajectory corrected;  ///< body poses of the keyframes
  Trajectory vio;        ///< the same keyframes as the VIO gave them
  std::vector<LoopRecord> loops;
};

/// Reads loops.csv, whose columns may stand in any order. Throws InputError that names file, line
/// and column.
std::vector<LoopRecord> ReadLoops(const std::filesystem::path& path);

/// Reads trajectory.txt, vio.txt and loops.csv; the run is named after the directory. Throws
/// InputError, also when the two trajectories are not of the same keyframes.
RunData ReadRun(const std::filesystem::path& directory);

/// A run beside the truth. Positions and errors are per keyframe, NaN where the truth has no pose;
/// without any truth, estimates stay in their own frames.
struct JudgedRun {
  RunData run;
  std::vector<Eigen::Vector3d> truth_path;  ///< the whole true flight over the run's time [m]
  std::vector<double> times_s;              ///< [s] since the first keyframe
  std::vector<Eigen::Vector3d> vio;         ///< [m] aligned with the truth
  std::vector<Eigen::Vector3d> corrected;   ///< [m] aligned with the truth
  std::vector<double> vio_errors;           ///< [m]
  std::vector<double> corrected_errors;     ///< [m]
  std::optional<ApeStatistics> vio_ape;
  std::optional<ApeStatistics> corrected_ape;
  std::vector<Verdict> verdicts;              ///< per loop record
  std::vector<std::pair<int, int>> ends;      ///< per loop record: (current, old) keyframe or -1
  std::optional<LoopScore> score;             ///< of the accepted loops
  std::vector<std::pair<int, int>> revisits;  ///< keyframes (current, old) of one place

  int AcceptedLoops() const;
  /// Recall can be told only with the camera's direction, and for loops within the run.
  bool HasRecall() const { return score && has_camera && !has_other_keyframes; }
  bool has_camera = false;
  bool has_other_keyframes = false;  ///< loops to keyframes of a loaded map
};

/// Aligns and judges. `truth` may be empty. `T_B_C` gives the viewing direction, without which
/// there are no revisits.
JudgedRun Judge(RunData run,
                const Trajectory& truth,
                const std::optional<Rigid3>& T_B_C,
                const LoopCriteria& criteria = {});

}  // namespace deja_view::report
