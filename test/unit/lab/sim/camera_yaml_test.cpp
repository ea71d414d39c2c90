#include "deja_view/lab/sim/camera_yaml.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/lab/sim/options.hpp"

#include <filesystem>

#include <gtest/gtest.h>

namespace deja_view::sim {
namespace {

TEST(CameraYaml, IsReadBack) {
  const auto path = std::filesystem::path(::testing::TempDir()) / "deja_view_sim_camera.yaml";
  const PinholeParameters parameters = SimulatedCamera({0.5});
  WriteFileAtomically(
      path, [&](std::ostream& out) { out << CameraYaml(parameters, SimulatedExtrinsic()); });
  const VinsConfig config = ReadVinsConfig(path);
  std::filesystem::remove(path);
  const PinholeCamera expected(parameters);
  const Eigen::Vector3d p_C(0.3, -0.5, 1.1);
  EXPECT_LT((*config.camera->Project(p_C) - *expected.Project(p_C)).norm(), 1e-5);
  EXPECT_EQ(config.camera->width(), 376);
  EXPECT_EQ(config.image_topic, "/cam0/image_raw");
  EXPECT_LT((config.T_B_C.t - SimulatedExtrinsic().t).norm(), 1e-9);
  EXPECT_LT(RotationAngle(config.T_B_C.q.conjugate() * SimulatedExtrinsic().q), 1e-9);
}

}  // namespace
}  // namespace deja_view::sim
