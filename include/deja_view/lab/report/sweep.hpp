#pragma once

#include "deja_view/lab/evaluation/threshold_sweep.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace deja_view::report {

/// The place that scores best for a keyframe, beside the truth.
struct Detection {
  std::int64_t stamp_current_ns = 0;
  std::int64_t stamp_old_ns = 0;
  ScoredDecision decision;
};

/// Places told by score alone: every keyframe's best place, and what a threshold r makes of them.
struct Sweep {
  std::string name;
  std::vector<SweepPoint> points;     ///< r falling
  std::vector<Detection> detections;  ///< by time; may be empty
};

/// Reads sweep.csv of a run's directory, and detections.csv where it is there, as `replay --out`
/// leaves them. The sweep is named after the directory. Throws InputError that names file and line.
Sweep ReadSweep(const std::filesystem::path& directory);

/// Every keyframe's best score over time, coloured by the truth, and precision and recall of the
/// threshold beside it on the same axis; a line at the r of largest recall with precision 1.
std::string ScoreFigure(const Sweep& sweep);

/// Precision over recall as the threshold falls, a line per sweep.
std::string SweepFigure(const std::vector<Sweep>& sweeps);

/// How many places are found over r, and how many of them are correct (the paper's Fig. 20).
std::string ThresholdFigure(const std::vector<Sweep>& sweeps);

/// The r of largest recall at precision 1 and 0.99 and what it finds, a row per sweep, the head
/// first.
std::vector<std::vector<std::string>> ThresholdRows(const std::vector<Sweep>& sweeps);

}  // namespace deja_view::report
