#include "deja_view/bundle/bundle_priors.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"

#include <cmath>

namespace deja_view {
std::vector<std::string> BundlePriorOptions::Validate() const {
  Requirements r;
  const char* const positive = "more than 0";
  const char* const not_negative = "0 or more";
  r.That(odometry_floor_m > 0, "odometry_floor_m", odometry_floor_m, positive);
  r.That(odometry_per_sqrt_m >= 0, "odometry_per_sqrt_m", odometry_per_sqrt_m, not_negative);
  r.That(odometry_floor_deg > 0, "odometry_floor_deg", odometry_floor_deg, positive);
  r.That(odometry_per_sqrt_m_deg >= 0,
         "odometry_per_sqrt_m_deg",
         odometry_per_sqrt_m_deg,
         not_negative);
  r.That(tilt_deg > 0, "tilt_deg", tilt_deg, positive);
  r.That(pose_m > 0, "pose_m", pose_m, positive);
  r.That(pose_deg > 0, "pose_deg", pose_deg, positive);
  return r.errors();
}

void AddOdometryPriors(const BundlePriorOptions& options,
                       const std::vector<Rigid3>& T_W_B,
                       const std::vector<int>& sequences,
                       BundleProblem* problem) {
  DEJA_VIEW_CHECK_OP(T_W_B.size(), ==, problem->images.size());
  DEJA_VIEW_CHECK_OP(sequences.size(), ==, problem->images.size());
  for (std::size_t i = 0; i < T_W_B.size(); ++i) {
    const auto image = static_cast<int>(i);
    problem->tilt_priors.push_back(
        {image, T_W_B[i].q.conjugate() * Eigen::Vector3d::UnitZ(), options.tilt_deg * kDegree});
    if (i > 0 && sequences[i] == sequences[i - 1]) {
      const Rigid3 T = T_W_B[i - 1].Inverse() * T_W_B[i];
      const double d = T.t.norm();
      problem->relative_priors.push_back(
          {image - 1,
           image,
           T,
           std::sqrt(std::pow(options.odometry_floor_m, 2) +
                     std::pow(options.odometry_per_sqrt_m, 2) * d),
           kDegree * std::sqrt(std::pow(options.odometry_floor_deg, 2) +
                               std::pow(options.odometry_per_sqrt_m_deg, 2) * d)});
    }
  }
}

void AddPosePriors(const BundlePriorOptions& options, BundleProblem* problem) {
  for (std::size_t i = 0; i < problem->images.size(); ++i) {
    problem->pose_priors.push_back({static_cast<int>(i),
                                    problem->images[i].T_W_B,
                                    options.pose_m,
                                    options.pose_deg * kDegree});
  }
}

void SetVelocities(const std::vector<int>& sequences, BundleProblem* problem) {
  constexpr double kMaxGap_s = 1.0;
  std::vector<BundleImage>& images = problem->images;
  DEJA_VIEW_CHECK_OP(sequences.size(), ==, images.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    const std::size_t before = i > 0 && sequences[i - 1] == sequences[i] ? i - 1 : i;
    const std::size_t after = i + 1 < images.size() && sequences[i + 1] == sequences[i] ? i + 1 : i;
    const double gap_s =
        1e-9 * static_cast<double>(images[after].stamp_ns - images[before].stamp_ns);
    if (gap_s > 0 && gap_s <= kMaxGap_s) {
      const Rigid3& from = images[before].T_W_B;
      const Rigid3& to = images[after].T_W_B;
      images[i].velocity_W = (to.t - from.t) / gap_s;
      images[i].angular_velocity_B =
          images[i].T_W_B.q.conjugate() * LogSo3(to.q * from.q.conjugate()) / gap_s;
    }
  }
}

}  // namespace deja_view
