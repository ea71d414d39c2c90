#pragma once

#include "deja_view/features/types.hpp"

#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// How likely it is that a wrong pose finds as many of the points that it should see. An
/// a-contrario bound: what chance explains is no evidence (Moisan and Stival, IJCV 2004; for poses
/// Moulon, Monasse, Marlet, ACCV 2012), here with the chance of every point in the very images.
///
/// Points that are found, or not, together form a group: it is found when one of its points is, by
/// chance with 1 - prod(1 - p) over them. The number of found groups is then a sum of independent
/// trials of unequal odds, whose distribution is computed exactly.
class ChanceOfSupport {
 public:
  explicit ChanceOfSupport(std::size_t groups);

  /// A point of the group that should be seen; a wrong pose finds it with `probability`.
  void AddVisible(std::size_t group, double probability);
  void AddFound(std::size_t group);

  /// log10 of the probability that chance finds as many groups, without `spent` of them: those that
  /// the pose was made from fit it anyway.
  double Log10Probability(int spent) const;

 private:
  std::vector<double> chance_of_none_;
  std::vector<bool> is_found_;
};

/// The image in 16 x 12 cells: that of `pixel`, and how many there are.
std::size_t CellOf(const Eigen::Vector2f& pixel, int width, int height);
inline constexpr std::size_t kImageCells = std::size_t{16} * 12;

/// Probability that at least one of `near` keypoints (expected number in the window) looks like
/// `point`, as those all over the image do: the share of `keypoints` within `max_distance` [bits].
/// Where the texture repeats itself, much looks alike, and a match says little.
double ChanceOfMatch(const Descriptor& point,
                     const std::vector<Descriptor>& keypoints,
                     int max_distance,
                     double near);

/// log10 P(X >= successes) for a sum of independent trials.
double Log10UpperTail(const std::vector<double>& probabilities, int successes);

}  // namespace deja_view
