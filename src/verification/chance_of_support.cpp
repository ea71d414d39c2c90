#include "chance_of_support.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view {

ChanceOfSupport::ChanceOfSupport(std::size_t groups)
    : chance_of_none_(groups, 1.0), is_found_(groups, false) {}

void ChanceOfSupport::AddVisible(std::size_t group, double probability) {
  chance_of_none_.at(group) *= 1.0 - probability;
}

void ChanceOfSupport::AddFound(std::size_t group) {
  is_found_.at(group) = true;
}

double ChanceOfSupport::Log10Probability(int spent) const {
  constexpr double kLeast =
      1e-3;  // of a group that is found though none of its points was predicted
  std::vector<double> probabilities;
  int found = 0;
  for (std::size_t i = 0; i < chance_of_none_.size(); ++i) {
    if (chance_of_none_[i] < 1.0 || is_found_[i]) {
      probabilities.push_back(std::max(kLeast, 1.0 - chance_of_none_[i]));
      found += is_found_[i] ? 1 : 0;
    }
  }
  return Log10UpperTail(probabilities, found - spent);
}

std::size_t CellOf(const Eigen::Vector2f& pixel, int width, int height) {
  constexpr int kColumns = 16;
  constexpr int kRows = kImageCells / kColumns;
  const int x = std::clamp(static_cast<int>(pixel.x()) * kColumns / width, 0, kColumns - 1);
  const int y = std::clamp(static_cast<int>(pixel.y()) * kRows / height, 0, kRows - 1);
  return static_cast<std::size_t>(y) * kColumns + static_cast<std::size_t>(x);
}

double ChanceOfMatch(const Descriptor& point,
                     const std::vector<Descriptor>& keypoints,
                     int max_distance,
                     double near) {
  constexpr std::size_t kSample = 128;
  const std::size_t step = std::max<std::size_t>(1, keypoints.size() / kSample);
  int tried = 0;
  int alike = 0;
  for (std::size_t i = 0; i < keypoints.size(); i += step) {
    ++tried;
    alike += HammingDistance(point, keypoints[i]) <= max_distance ? 1 : 0;
  }
  // Krichevsky and Trofimov's estimate: never 0 of a finite sample.
  const double share = (alike + 0.5) / (tried + 1.0);
  return 1.0 - std::pow(1.0 - share, near);
}

double Log10UpperTail(const std::vector<double>& probabilities, int successes) {
  constexpr double kSmallest = 1e-300;
  if (successes <= 0) {
    return 0.0;
  }
  // counts[k]: probability of k < successes so far; what reaches `successes` stays there.
  std::vector<double> counts(static_cast<std::size_t>(successes), 0.0);
  counts[0] = 1.0;
  double tail = 0.0;
  for (const double p : probabilities) {
    tail += p * counts.back();
    for (std::size_t k = counts.size() - 1; k > 0; --k) {
      counts[k] += p * (counts[k - 1] - counts[k]);
    }
    counts[0] *= 1.0 - p;
  }
  return std::log10(std::max(kSmallest, tail));
}

}  // namespace deja_view
