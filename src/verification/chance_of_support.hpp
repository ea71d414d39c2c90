#pragma once

#include "deja_view/features/types.hpp"

#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// How likely it is that a wrong pose finds as many of the points that it should see. An
/// a-contrario bound: what chance explains is no evidence (Moisan and Stival, IJCV 2004; for poses
/// Moulon, Monasse, Marlet, ACCV 2012), here with the chance of every point in the very images, and
/// with matches that crowd counted once: neighbouring points match, or fail to, together.
///
/// The image is cut into 16 x 12 cells. A cell is found when one of its points is; by chance it is
/// with 1 - prod(1 - p) over its visible points. The number of found cells is then a sum of
/// independent trials of unequal odds, whose distribution is computed exactly.
class ChanceOfSupport {
 public:
  /// Of the image that cells are counted on [px].
  ChanceOfSupport(int width, int height);

  /// A point that should be seen, at `pixel`; a wrong pose finds it with `probability`.
  void AddVisible(const Eigen::Vector2f& pixel, double probability);
  void AddFound(const Eigen::Vector2f& pixel);

  /// log10 of the probability that chance finds as many cells, without `spent` of them: those that
  /// the pose was made from fit it anyway.
  double Log10Probability(int spent) const;

 private:
  static constexpr int kColumns = 16;
  static constexpr int kRows = 12;
  std::size_t CellOf(const Eigen::Vector2f& pixel) const;

  int width_;
  int height_;
  std::vector<double> chance_of_none_;
  std::vector<bool> is_found_;
};

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
