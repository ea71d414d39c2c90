#pragma once

#include <cstddef>
#include <vector>

namespace deja_view {

/// Which few of many sets cover most: sets and what they cover are numbered alike. Each element q
/// is covered by a set v to a degree in [0, 1], and by several to the highest of their degrees.
class MaxCoverage {
 public:
  explicit MaxCoverage(std::size_t count) : covered_(count, 0.0), by_element_(count) {}

  /// From the start q is covered to this degree. Safe for several q at once.
  void Raise(std::size_t q, double degree);

  /// v covers q to this degree. Safe for several q at once.
  void Add(std::size_t q, std::size_t v, double degree);

  /// At most `budget` sets, each that which adds most to the sum of degrees, and at least
  /// `min_gain`; of equals the first. Call it once.
  std::vector<std::size_t> Choose(std::size_t budget, double min_gain);

 private:
  struct Degree {
    std::size_t number;
    double degree;
  };

  double Gain(const std::vector<Degree>& set) const;

  std::vector<double> covered_;
  std::vector<std::vector<Degree>> by_element_;
};

}  // namespace deja_view
