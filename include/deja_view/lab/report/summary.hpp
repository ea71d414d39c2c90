#pragma once

#include "deja_view/lab/report/run.hpp"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace deja_view::report {

/// Errors and loops of runs side by side, beside the first run's VIO, as lines of plain text.
std::string SummaryTable(const std::vector<JudgedRun>& runs);

/// The same figures for programs: an array with an object per run, null for what is unknown.
/// Keys are those of `deja_view replay --json`, and `name`.
nlohmann::ordered_json SummaryJson(const std::vector<JudgedRun>& runs);

}  // namespace deja_view::report
