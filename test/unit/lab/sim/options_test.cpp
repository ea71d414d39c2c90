#include "deja_view/lab/sim/options.hpp"

#include "deja_view/base/check.hpp"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view::sim {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(SimOptions, EveryPresetIsValid) {
  for (const std::string& name : PresetNames()) {
    EXPECT_THAT(MakePreset(name).Validate(), IsEmpty()) << name;
  }
}

TEST(SimOptions, ReportsAllViolationsAtOnce) {
  SimOptions options;
  options.world.texture_size_px = 300;
  options.imu.rate_hz = std::numeric_limits<double>::quiet_NaN();
  options.sensor.exposure_ms = 90;
  options.sensor.image_rate_hz = 20;
  EXPECT_THAT(options.Validate(),
              ElementsAre(HasSubstr("world.texture_size_px: 300"),
                          HasSubstr("sensor.exposure_ms: 90"),
                          HasSubstr("imu.rate_hz: nan")));
}

TEST(SimOptions, UnknownPresetIsNamedWithTheKnownOnes) {
  try {
    MakePreset("cathedral");
    FAIL() << "no exception";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("cathedral"));
    EXPECT_THAT(e.what(), HasSubstr("weak_texture"));
  }
}

TEST(SimulatedCamera, ScalesAboutPixelCentres) {
  const PinholeCamera full(SimulatedCamera({1.0}));
  const PinholeCamera half(SimulatedCamera({0.5}));
  EXPECT_EQ(half.width(), 376);
  EXPECT_EQ(half.height(), 240);
  const Eigen::Vector3d p_C(0.4, -0.2, 1.3);
  const Eigen::Vector2d in_full = *full.Project(p_C);
  const Eigen::Vector2d in_half = *half.Project(p_C);
  EXPECT_LT(
      ((in_full + Eigen::Vector2d(0.5, 0.5)) / 2 - in_half - Eigen::Vector2d(0.5, 0.5)).norm(),
      1e-9);
}

TEST(SimulatedExtrinsic, CameraLooksAlongTheBodysZ) {
  const Rigid3 T_B_C = SimulatedExtrinsic();
  EXPECT_GT((T_B_C.q * Eigen::Vector3d::UnitZ()).z(), 0.99);
  EXPECT_LT((T_B_C.q * Eigen::Vector3d::UnitY()).x(), -0.99);
}

}  // namespace
}  // namespace deja_view::sim
