#include "nerf_input.hpp"

#include "deja_view/io/tum.hpp"
#include "deja_view/io/vins_config.hpp"

namespace deja_view {

nerf::Split ReadNerfInput(const NerfInput& input) {
  const VinsConfig config = ReadVinsConfig(input.camera);
  const Rigid3 T_B_C = input.poses_of == "body" ? config.T_B_C : Rigid3::Identity();
  return nerf::HoldOut(
      nerf::ReadTrajectoryImages(input.images, config.camera, T_B_C, ReadTum(input.poses)),
      input.holdout);
}

std::vector<nerf::TrainingView> LoadTrainingViews(const NerfInput& input, int threads) {
  return nerf::LoadViews(ReadNerfInput(input).training, input.color ? 3 : 1, input.scale, threads);
}

}  // namespace deja_view
