#pragma once

#include "deja_view/pipeline/loop_closer.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace deja_view {

/// Some of a flight's loops with their matched pixels, spread evenly over all loops, for a report:
/// of those that rest on real images alone and of those with virtual views at most `at_most` each,
/// and at least half as many where there were so many. Memory does not grow with the flight.
class MatchSamples {
 public:
  explicit MatchSamples(std::size_t at_most = 8);

  void Add(const LoopMatches& matches);

  /// By the time of the current keyframe.
  std::vector<LoopMatches> Sorted() const;

 private:
  struct Thinned {
    std::vector<LoopMatches> kept;
    std::uint64_t seen = 0;
    std::uint64_t stride = 1;  ///< every so many of those seen are kept
  };

  std::size_t at_most_;
  Thinned real_;
  Thinned virtual_;
};

}  // namespace deja_view
