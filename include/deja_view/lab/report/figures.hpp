#pragma once

#include "deja_view/lab/report/run.hpp"

#include <string>
#include <vector>

namespace deja_view::report {

/// Each figure is a whole SVG document that stands alone and suits light and dark pages.

/// The flight from above, twice: as the VIO gave it and corrected, coloured by the error where the
/// truth is known, over the true path; accepted loops join their keyframes.
std::string TrajectoryFigure(const JudgedRun& run);

/// Position error over time: of the first run's VIO, and of every run's corrected trajectory, with
/// means; below, when loops were accepted (in the first run). At least one run.
std::string ErrorFigure(const std::vector<JudgedRun>& runs);

/// Every verified candidate as a dot: when it was flown over the time of the place it was taken
/// for. Shaded where the truth says that it is the same place.
std::string LoopFigure(const JudgedRun& run);

/// "1 loop", "12 loops".
std::string Count(int count, const std::string& noun);

}  // namespace deja_view::report
