#pragma once

#include "deja_view/geometry/alignment.hpp"

#include <filesystem>

namespace deja_view::nerf {

/// Where N, the frame of a field's training poses, lies in the world W of poses in metres.
struct FieldFrame {
  bool is_known = true;  ///< false: the poses were structure from motion's, without a scale
  Similarity3 W_N;       ///< the identity: they were in W themselves

  bool IsWorld() const {
    return is_known && W_N.scale == 1 && W_N.T_A_B.t.isZero(0) &&
           W_N.T_A_B.q.coeffs() == Eigen::Quaterniond::Identity().coeffs();
  }
};

/// W_N. Throws InputError that names the model and the way out where nobody knows it.
const Similarity3& RequireFrame(const FieldFrame& frame, const std::filesystem::path& model);

}  // namespace deja_view::nerf
