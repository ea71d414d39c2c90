#pragma once

#include <vector>

namespace deja_view {

/// What one keyframe would be matched with, and how surely.
struct ScoredDecision {
  double score = 0;
  bool is_correct = false;  ///< the match is right
  bool is_revisit = true;   ///< the truth says that there is something to find
};

/// Precision and recall when only decisions with a score of at least `r` count.
struct SweepPoint {
  double r = 0;
  int found = 0;    ///< decisions that count
  int correct = 0;  ///< of these, the right ones
  double precision = 1;
  double recall = 0;  ///< right ones at revisits, over `revisits`
};

/// One point per distinct score, r falling; recall rises along it. `revisits`: how many keyframes
/// there are to find, with or without a decision. No decisions give no points.
std::vector<SweepPoint> SweepThreshold(std::vector<ScoredDecision> decisions, int revisits);

/// The point of largest recall with at least this precision (the paper's choice of r, Fig. 20); of
/// equal ones that of the largest r. r is infinite and recall 0 where there is none.
SweepPoint PickThreshold(const std::vector<SweepPoint>& sweep, double precision);

}  // namespace deja_view
