#include "lens_view.hpp"

#include "deja_view/camera/camera_parameters.hpp"

#include <random>

#include "plain_field.hpp"
#include <gtest/gtest.h>

namespace deja_view::nerf::internal {
namespace {

// Also beyond the image, and beyond what the lens can see.
void ExpectSameRays(const CameraParameters& parameters, double tolerance = 1e-9) {
  const auto camera = MakeCamera(parameters, "test");
  const LensView lens = LensOf(*camera);
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> uniform(-0.6, 1.6);
  for (int i = 0; i < 500; ++i) {
    const double u = uniform(rng) * camera->width();
    const double v = uniform(rng) * camera->height();
    const Eigen::Vector3d expected = camera->Unproject({u, v});
    const std::array<double, 3> found = lens.Unproject(u, v);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(found[axis], expected[static_cast<Eigen::Index>(axis)], tolerance)
          << parameters.model << " " << u << " " << v;
    }
  }
}

TEST(LensView, UnprojectsAsThePinholeDoes) {
  ExpectSameRays({"PINHOLE", 75, 48, {0, 0, 0, 0}, {46, 45, 36.7, 24.8}});
  ExpectSameRays({"PINHOLE", 75, 48, {-0.28, 0.07, 2e-4, 2e-5}, {46, 45, 36.7, 24.8}});
  ExpectSameRays({"PINHOLE", 75, 48, {0.1, -0.2, 1e-2, -1e-2}, {46, 45, 36.7, 24.8}});
}

TEST(LensView, UnprojectsAsTheFisheyeDoes) {
  ExpectSameRays({"KANNALA_BRANDT", 64, 61, {-0.01, 0.02, -0.01, 0.001}, {20, 21, 31.5, 29}});
  ExpectSameRays({"KANNALA_BRANDT", 64, 61, {-0.3, 0, 0, 0}, {20, 21, 31.5, 29}});
}

TEST(LensView, UnprojectsAsTheMirrorDoes) {
  ExpectSameRays({"MEI", 60, 50, {-0.2, 0.05, 1e-3, -1e-3}, {0.8, 60, 61, 30, 25}});
  // At the sphere's outline a root of nearly 0 halves the digits.
  ExpectSameRays({"MEI", 60, 50, {-0.1, 0.01, 1e-3, 1e-3}, {1.6, 60, 61, 30, 25}}, 1e-7);
}

}  // namespace
}  // namespace deja_view::nerf::internal
