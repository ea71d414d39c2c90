#include "deja_view/geometry/alignment.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>

namespace deja_view {
Eigen::Vector3d MeanPoint(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    sum += p;
  }
  return sum / static_cast<double>(points.size());
}

Similarity3 AlignPoints(const std::vector<Eigen::Vector3d>& p_A,
                        const std::vector<Eigen::Vector3d>& p_B,
                        bool with_scale) {
  DEJA_VIEW_CHECK_OP(p_A.size(), ==, p_B.size());
  DEJA_VIEW_CHECK_OP(p_A.size(), >=, 3U);
  using Points = Eigen::Map<const Eigen::Matrix3Xd>;
  const auto count = static_cast<Eigen::Index>(p_A.size());
  const Points A(p_A.front().data(), 3, count);
  const Points B(p_B.front().data(), 3, count);
  const Eigen::Matrix4d T = Eigen::umeyama(B, A, with_scale);
  const double scale = with_scale ? T.topLeftCorner<3, 3>().col(0).norm() : 1.0;
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>() / scale;
  return {scale, {Eigen::Quaterniond(R).normalized(), T.topRightCorner<3, 1>()}};
}

Rigid3 AlignYaw(const std::vector<Eigen::Vector3d>& p_A, const std::vector<Eigen::Vector3d>& p_B) {
  DEJA_VIEW_CHECK_OP(p_A.size(), ==, p_B.size());
  DEJA_VIEW_CHECK_OP(p_A.size(), >, 0U);
  const Eigen::Vector3d mean_A = MeanPoint(p_A);
  const Eigen::Vector3d mean_B = MeanPoint(p_B);
  double cosine = 0;
  double sine = 0;
  for (std::size_t i = 0; i < p_A.size(); ++i) {
    const Eigen::Vector3d a = p_A[i] - mean_A;
    const Eigen::Vector3d b = p_B[i] - mean_B;
    cosine += b.x() * a.x() + b.y() * a.y();
    sine += b.x() * a.y() - b.y() * a.x();
  }
  const Eigen::Quaterniond q = FromYaw(std::atan2(sine, cosine));
  return {q, mean_A - q * mean_B};
}

}  // namespace deja_view
