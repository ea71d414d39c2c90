#include "deja_view/host/odometry_check.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>

#include <Eigen/Eigenvalues>

namespace deja_view {
namespace {

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

MotionFigures MeasureMotion(const std::vector<std::int64_t>& stamps_ns,
                            const std::vector<Rigid3>& poses) {
  DEJA_VIEW_CHECK(stamps_ns.size() == poses.size());
  MotionFigures figures;
  std::vector<double> speeds;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const double metres = (poses[i].t - poses[i - 1].t).norm();
    figures.path_m += metres;
    speeds.push_back(metres / (1e-9 * static_cast<double>(stamps_ns[i] - stamps_ns[i - 1])));
  }
  if (!speeds.empty()) {
    figures.max_mps = *std::max_element(speeds.begin(), speeds.end());
    figures.median_mps = Median(std::move(speeds));
  }
  return figures;
}

std::optional<Eigen::Vector3d> UpFromLevelRows(const std::vector<Rigid3>& T_W_C) {
  constexpr double kLeastSpread = 0.02;
  if (T_W_C.empty()) {
    return std::nullopt;
  }
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Rigid3& pose : T_W_C) {
    const Eigen::Vector3d row_W = pose.q * Eigen::Vector3d::UnitX();
    spread += row_W * row_W.transpose() / static_cast<double>(T_W_C.size());
  }
  return UpFromRowSpread(spread, kLeastSpread);
}

std::optional<Eigen::Vector3d> UpFromRowSpread(const Eigen::Matrix3d& spread, double least_spread) {
  constexpr double kClearly = 3;  // more than across the third
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  const Eigen::Vector3d& values = solver.eigenvalues();  // ascending
  if (values[1] < least_spread || values[1] < kClearly * values[0]) {
    return std::nullopt;
  }
  return solver.eigenvectors().col(0);
}

std::optional<double> MedianReprojection(const Rigid3& T_W_C,
                                         const std::vector<TrackedPoint>& points,
                                         const Camera& camera) {
  const Rigid3 T_C_W = T_W_C.Inverse();
  std::vector<double> errors_px;
  for (const TrackedPoint& point : points) {
    if (const auto pixel = camera.Project(T_C_W * point.p_W)) {
      errors_px.push_back((*pixel - point.pixel.cast<double>()).norm());
    }
  }
  return errors_px.empty() ? std::nullopt : std::optional(Median(std::move(errors_px)));
}

}  // namespace deja_view
