#include "reprojection_error.hpp"

#include "deja_view/camera/kannala_brandt_camera.hpp"
#include "deja_view/camera/mei_camera.hpp"
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <memory>
#include <vector>

#include "bundle_scene.hpp"
#include "camera_block.hpp"
#include "jacobian_check.hpp"

namespace deja_view::internal {
namespace {

using test::ExpectJacobiansMatch;
using test::Residuals;

std::vector<std::shared_ptr<const Camera>> AllModels() {
  KannalaBrandtParameters kb{640, 480, -0.01, 0.02, -0.01, 0.002, 300, 302, 321, 239};
  MeiParameters mei{640, 480, 0.9, -0.2, 0.05, 0.001, -0.001, 600, 602, 321, 239};
  return {std::make_shared<PinholeCamera>(test::BundleLens()),
          std::make_shared<KannalaBrandtCamera>(kb),
          std::make_shared<MeiCamera>(mei)};
}

ImageReference Reference(CameraBlock* camera) {
  ImageReference reference;
  reference.R_W_B = ExpSo3({0.3, -0.2, 0.9}).toRotationMatrix();
  reference.R_B_C = ExpSo3({0.1, 0.2, -1.4}).toRotationMatrix();
  reference.velocity_W = {0.8, -0.5, 0.2};
  reference.angular_velocity_B = {0.3, 0.9, -0.4};
  reference.camera = camera;
  return reference;
}

/// Blocks at which `p_C` (with all deltas zero) is seen.
std::vector<Eigen::VectorXd> Blocks(const ImageReference& reference, const Eigen::Vector3d& p_C) {
  const Eigen::Vector3d t_W_B(1, 2, 3);
  const Eigen::Vector3d t_B_C(0.05, -0.1, 0.02);
  Eigen::VectorXd body = Eigen::VectorXd::Zero(6);
  body.tail<3>() = t_W_B;
  Eigen::VectorXd extrinsics = Eigen::VectorXd::Zero(6);
  extrinsics.tail<3>() = t_B_C;
  const Eigen::VectorXd point = reference.R_W_B * (reference.R_B_C * p_C + t_B_C) + t_W_B;
  const CameraParameters& p = reference.camera->parameters();
  return {body,
          point,
          extrinsics,
          Eigen::VectorXd::Zero(1),
          Eigen::Map<const Eigen::VectorXd>(p.projection.data(), p.projection.size()),
          Eigen::Map<const Eigen::VectorXd>(p.distortion.data(), p.distortion.size())};
}

TEST(ReprojectionError, IsTheDifferenceOfPixelsInSigmas) {
  for (const auto& camera : AllModels()) {
    CameraBlock block(*camera);
    const ImageReference reference = Reference(&block);
    const Eigen::Vector3d p_C(0.3, -0.4, 2.0);
    const Eigen::Vector2d pixel = camera->Project(p_C).value();
    const ReprojectionError error(reference, pixel - Eigen::Vector2d(1.5, -0.5), 0.5);
    EXPECT_TRUE(
        Residuals(error, Blocks(reference, p_C)).isApprox(Eigen::Vector2d(3.0, -1.0), 1e-9));
  }
}

TEST(ReprojectionError, LooksFromWhereTheCameraIsWhenTheImageIsTaken) {
  CameraBlock block(*AllModels().front());
  ImageReference reference = Reference(&block);
  const Eigen::Vector3d p_C(0.3, -0.4, 2.0);
  std::vector<Eigen::VectorXd> blocks = Blocks(reference, p_C);
  const double dt = 0.03;
  blocks[ReprojectionError::kTimeOffset][0] = dt;
  const Rigid3 T_W_B{
      Eigen::Quaterniond(reference.R_W_B) * ExpSo3(dt * reference.angular_velocity_B),
      blocks[ReprojectionError::kBody].tail<3>() + dt * reference.velocity_W};
  const Rigid3 T_B_C{Eigen::Quaterniond(reference.R_B_C),
                     blocks[ReprojectionError::kExtrinsics].tail<3>()};
  const Eigen::Vector3d moved =
      (T_W_B * T_B_C).Inverse() * Eigen::Vector3d(blocks[ReprojectionError::kPoint]);
  const ReprojectionError error(reference, AllModels().front()->Project(moved).value(), 1.0);
  EXPECT_LT(Residuals(error, blocks).norm(), 1e-9);
}

TEST(ReprojectionError, JacobiansMatchDifferencesForEveryModel) {
  for (const auto& camera : AllModels()) {
    CameraBlock block(*camera);
    const ImageReference reference = Reference(&block);
    std::vector<Eigen::VectorXd> blocks = Blocks(reference, {0.3, -0.4, 2.0});
    // Away from where the rotation vectors are zero and the offset has no effect.
    blocks[ReprojectionError::kBody].head<3>() = Eigen::Vector3d(0.05, -0.1, 0.08);
    blocks[ReprojectionError::kExtrinsics].head<3>() = Eigen::Vector3d(-0.03, 0.04, 0.06);
    blocks[ReprojectionError::kTimeOffset][0] = 0.02;
    const ReprojectionError error(reference, {300, 200}, 0.7);
    ExpectJacobiansMatch(error, blocks, 2e-5);
  }
}

TEST(ReprojectionError, IsLargeAndFlatWhereThePointIsNotSeen) {
  CameraBlock block(*AllModels().front());
  const ImageReference reference = Reference(&block);
  const ReprojectionError error(reference, {300, 200}, 0.5);
  const std::vector<Eigen::VectorXd> blocks = Blocks(reference, {0.3, -0.4, -2.0});
  EXPECT_TRUE(Residuals(error, blocks)
                  .isApprox(Eigen::Vector2d::Constant(ReprojectionError::kUnseenPx / 0.5)));
  ExpectJacobiansMatch(error, blocks, 1e-12);
}

}  // namespace
}  // namespace deja_view::internal
