#pragma once

#include "deja_view/geometry/rigid3.hpp"

namespace deja_view {

/// T_B_C of a camera that looks along the body's x.
inline const Rigid3 kLooksAhead{Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0, 0, 0}};

}  // namespace deja_view
