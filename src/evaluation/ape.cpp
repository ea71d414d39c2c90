#include "deja_view/evaluation/ape.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/geometry/alignment.hpp"

#include <algorithm>
#include <cmath>
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

ApeStatistics ComputeApe(const std::vector<Eigen::Vector3d>& truth,
                         const std::vector<Eigen::Vector3d>& estimate) {
  return Statistics(truth, estimate, AlignPoints(truth, estimate).T_A_B);
}

ApeStatistics ComputeApeUnaligned(const std::vector<Eigen::Vector3d>& truth,
                                  const std::vector<Eigen::Vector3d>& estimate) {
  DEJA_VIEW_CHECK_OP(truth.size(), ==, estimate.size());
  DEJA_VIEW_CHECK_OP(truth.size(), >=, 1U);
  return Statistics(truth, estimate, Rigid3::Identity());
}

}  // namespace deja_view
