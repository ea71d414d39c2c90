#include "deja_view/geometry/alignment.hpp"

#include "deja_view/base/check.hpp"

namespace deja_view {

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

}  // namespace deja_view
