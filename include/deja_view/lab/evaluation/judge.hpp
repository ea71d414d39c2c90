#pragma once

#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/geometry/trajectory.hpp"
#include "deja_view/lab/evaluation/ape.hpp"
#include "deja_view/lab/evaluation/loop_score.hpp"
#include "deja_view/lab/evaluation/relocalisation.hpp"
#include "deja_view/lab/evaluation/threshold_sweep.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace deja_view {

/// A keyframe as a flight left it.
struct FlownKeyframe {
  std::int64_t stamp_ns = 0;
  Rigid3 T_M_B;            ///< [m] corrected
  Rigid3 T_W_B;            ///< [m] as the odometry gave it
  bool is_of_map = false;  ///< of a loaded map: can be found again, finds nothing itself
  bool is_place = true;    ///< can be found again
  bool has_poses = true;   ///< false: only the stamp is known
};

/// A verified candidate; `old` and `current` are indices of keyframes.
struct FlownLoop {
  int old = -1;
  int current = -1;
  Rigid3 T_Bold_Bcurrent;  ///< [m]
  double score = 0;
  bool is_virtual = false;
  bool is_accepted = true;
};

/// The place that scores best for a keyframe, without geometry.
struct FlownDetection {
  int old = -1;
  int current = -1;
  double score = 0;
};

/// All of a flight that the truth can tell something about.
struct Flight {
  std::vector<FlownKeyframe> keyframes;  ///< the flight's own by time
  std::vector<FlownLoop> loops;
  std::vector<FlownDetection> detections;
};

/// True body poses; a loaded map has a truth of its own.
struct FlightTruth {
  Trajectory own;
  Trajectory map;
};

struct JudgeOptions {
  LoopCriteria criteria;
  LoopCriteria map_criteria;  ///< what counts as a revisit of a loaded map's place
};

/// What the truth says about a candidate.
enum class Verdict { kUnknown, kCorrect, kWrong };

/// A flight beside the truth.
struct JudgedFlight {
  std::vector<TrueKeyframe> keyframes;
  std::vector<Verdict> verdicts;  ///< per loop, accepted or not
  LoopScore score;                ///< of the accepted loops
  int virtual_loops = 0;          ///< accepted, with virtual views
  int virtual_correct = 0;

  /// Keyframes near a place of the loaded map by its criteria, and those with a correct loop to it.
  int map_revisits = 0;
  int map_revisits_found = 0;
  std::optional<RelocalisationCurve> relocalisation;  ///< with a loaded map

  /// Places told by score alone (the paper's Fig. 20): per detection whose two ends have a true
  /// pose what it is worth, and the sweep of these.
  std::vector<std::optional<ScoredDecision>> decisions;
  std::vector<SweepPoint> detections;
  double recall_at_precision_1 = 0;  ///< of the loops, when only those of a score from some r count

  // Over the keyframes with a true pose, where there are three.
  std::optional<ApeStatistics> ape;
  std::optional<ApeStatistics> vio_ape;
  std::optional<ApeStatistics> map_frame_ape;  ///< in the map's frame, aligned by the map alone
};

/// The one judge of replays and of reports. A true pose is that of the truth at the keyframe's
/// stamp, interpolated over at most 0.1 s. `T_B_C` gives the viewing direction, the camera's z.
JudgedFlight JudgeFlight(const Flight& flight,
                         const FlightTruth& truth,
                         const Rigid3& T_B_C,
                         const JudgeOptions& options = {});

}  // namespace deja_view
