#include "deja_view/bundle/bundle_problem.hpp"

namespace deja_view {

Rigid3 BundleProblem::CameraPose(int image) const {
  const BundleImage& i = images[static_cast<std::size_t>(image)];
  const BundleCamera& camera = cameras[static_cast<std::size_t>(i.camera)];
  const double dt = camera.time_offset_s;
  const Rigid3 T_W_B{(i.T_W_B.q * ExpSo3(dt * i.angular_velocity_B)).normalized(),
                     i.T_W_B.t + dt * i.velocity_W};
  return T_W_B * camera.T_B_C;
}

}  // namespace deja_view
