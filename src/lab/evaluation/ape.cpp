#include "deja_view/lab/evaluation/ape.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/geometry/alignment.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <numeric>

namespace deja_view {
namespace {

/// Median as numpy computes it: the mean of the two middle values of an even count.
double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

ApeStatistics Statistics(const std::vector<Eigen::Vector3d>& truth,
                         const std::vector<Eigen::Vector3d>& estimate,
                         const Rigid3& T_truth_estimate) {
  ApeStatistics ape;
  ape.T_truth_estimate = T_truth_estimate;
  double squares = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double error = (truth[i] - T_truth_estimate * estimate[i]).norm();
    ape.errors.push_back(error);
    squares += error * error;
  }
  const auto count = static_cast<double>(truth.size());
  ape.max = *std::max_element(ape.errors.begin(), ape.errors.end());
  ape.min = *std::min_element(ape.errors.begin(), ape.errors.end());
  ape.mean = std::accumulate(ape.errors.begin(), ape.errors.end(), 0.0) / count;
  ape.median = Median(ape.errors);
  ape.rmse = std::sqrt(squares / count);
  return ape;
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> PairByStamp(
    const std::vector<std::int64_t>& first_ns,
    const std::vector<std::int64_t>& second_ns,
    std::int64_t max_difference_ns) {
  const bool is_second_longer = second_ns.size() > first_ns.size();
  const auto& shorter = is_second_longer ? first_ns : second_ns;
  const auto& longer = is_second_longer ? second_ns : first_ns;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < shorter.size() && !longer.empty(); ++i) {
    auto nearest = std::lower_bound(longer.begin(), longer.end(), shorter[i]);
    if (nearest == longer.end() ||
        (nearest != longer.begin() && shorter[i] - *std::prev(nearest) <= *nearest - shorter[i])) {
      --nearest;
    }
    if (std::abs(*nearest - shorter[i]) <= max_difference_ns) {
      const auto k = static_cast<std::size_t>(nearest - longer.begin());
      pairs.emplace_back(is_second_longer ? i : k, is_second_longer ? k : i);
    }
  }
  return pairs;
}

ApeStatistics ComputeApe(const std::vector<Eigen::Vector3d>& truth,
                         const std::vector<Eigen::Vector3d>& estimate,
                         ApeAlignment alignment) {
  switch (alignment) {
    case ApeAlignment::kYaw:
      DEJA_VIEW_CHECK_OP(truth.size(), >=, 3U);
      return Statistics(truth, estimate, AlignYaw(truth, estimate));
    case ApeAlignment::kNone:
      return ComputeApeUnaligned(truth, estimate);
    case ApeAlignment::kSe3:
      break;
  }
  return Statistics(truth, estimate, AlignPoints(truth, estimate).T_A_B);
}

ApeStatistics ComputeApeUnaligned(const std::vector<Eigen::Vector3d>& truth,
                                  const std::vector<Eigen::Vector3d>& estimate) {
  DEJA_VIEW_CHECK_OP(truth.size(), ==, estimate.size());
  DEJA_VIEW_CHECK_OP(truth.size(), >=, 1U);
  return Statistics(truth, estimate, Rigid3::Identity());
}

}  // namespace deja_view
