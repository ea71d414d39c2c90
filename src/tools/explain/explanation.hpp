#pragma once

#include "deja_view/pipeline/loop_closer_types.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace deja_view {

/// A stamp as people write it: nanoseconds (as in loops.csv: at least 11 digits) or seconds with or
/// without decimals (as in trajectory.txt), exact to the nanosecond. Throws InputError that names
/// `option` otherwise.
std::int64_t ParseStamp(const std::string& option, const std::string& text);

/// The last that was decided of the pair: of loops that waited for others, or were withdrawn.
/// `loops`: all reports of the flight, in their order.
RejectReason FinalReason(const PairExplanation& pair, const std::vector<LoopReport>& loops);

/// In words: what was found, and what would have let the pair pass. `final_reason`: FinalReason.
std::vector<std::string> ExplanationLines(const PairExplanation& pair, RejectReason final_reason);

/// The figures behind it.
nlohmann::ordered_json ToJson(const PairExplanation& pair, RejectReason final_reason);

}  // namespace deja_view
