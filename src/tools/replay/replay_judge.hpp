#pragma once

#include "deja_view/geometry/trajectory.hpp"

#include <string>

#include "replay/replay.hpp"
#include <nlohmann/json.hpp>

namespace deja_view {

/// What the truth says about a replay, in words and figures.
struct ReplayVerdict {
  nlohmann::ordered_json figures = nlohmann::ordered_json::object();  ///< what ToJson leaves open
  // For the printed table, empty where there is nothing to tell.
  std::string loops;   ///< ends the line that counts the loops
  std::string map;     ///< a line
  std::string errors;  ///< lines
};

/// Judges by `request.groundtruth`, without which its verdict is empty. In a build without the
/// laboratory there is none that judges.
class ReplayJudge {
 public:
  /// Reads the truth. Throws InputError for bad files, and in a build that can't judge. The request
  /// must live on.
  explicit ReplayJudge(const ReplayRequest& request);

  /// Writes sweep.csv and detections.csv to `request.out`, too.
  ReplayVerdict Judge(const ReplayResult& result) const;

 private:
  const ReplayRequest& request_;
  Trajectory truth_;
  Trajectory map_truth_;
};

}  // namespace deja_view
