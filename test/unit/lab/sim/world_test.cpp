#include "deja_view/lab/sim/world.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/lab/sim/image_sensor.hpp"
#include "deja_view/lab/sim/renderer.hpp"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "small_world.hpp"
#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>

namespace deja_view::sim {
namespace {

TEST(World, IsClosedToEverySide) {
  const auto world = TinyWorld();
  Rng rng(1, 1);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d ray =
        Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
    EXPECT_TRUE(CastRay(world->scene(), LookAlong(*world, 0).t, ray));
  }
}

TEST(World, ClearanceAgreesWithRays) {
  const auto world = TinyWorld();
  Rng rng(2, 1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p(rng.Uniform(0.5, world->size().x() - 0.5),
                            rng.Uniform(0.5, world->size().y() - 0.5),
                            rng.Uniform(0.3, 2.0));
    const double clearance = world->Clearance(p);
    if (clearance < 0.3) {
      continue;
    }
    const Eigen::Vector3d ray =
        Eigen::Vector3d(rng.Normal(), rng.Normal(), 0.2 * rng.Normal()).normalized();
    const auto hit = CastRay(world->scene(), p, ray);
    ASSERT_TRUE(hit);
    EXPECT_GT(hit->range, clearance - 0.1);  // posters and windows stand a little off the wall
  }
}

TEST(World, SameSeedSameHall) {
  const World again(1, TinyOptions().world, 3);
  const World other(2, TinyOptions().world, 1);
  const auto world = TinyWorld();
  EXPECT_EQ(world->scene().light, again.scene().light);
  ASSERT_EQ(world->scene().surfaces.size(), again.scene().surfaces.size());
  for (std::size_t i = 0; i < again.scene().surfaces.size(); ++i) {
    EXPECT_EQ(world->scene().surfaces[i].origin, again.scene().surfaces[i].origin);
    EXPECT_EQ(world->scene().surfaces[i].texture, again.scene().surfaces[i].texture);
  }
  EXPECT_NE(world->scene().light, other.scene().light);
}

TEST(World, RepetitionLeavesFewTextures) {
  WorldOptions options = TinyOptions().world;
  options.repetition = 1.0;
  const World repeated(1, options, 1);
  EXPECT_LT(repeated.scene().textures.size(), TinyWorld()->scene().textures.size() / 3);
}

TEST(World, LightIsFiniteAndNotNegative) {
  for (const float light : TinyWorld()->scene().light) {
    ASSERT_TRUE(std::isfinite(light) && light >= 0);
  }
}

/// What a camera in the hall of a preset sees to eight sides.
std::vector<cv::Mat> PhotographHall(const std::string& preset) {
  SimOptions options = MakePreset(preset);
  options.camera.scale = 0.5;
  options.world.texture_size_px = 256;
  options.world.light_spacing_m = 0.5;
  const auto camera = std::make_shared<PinholeCamera>(SimulatedCamera(options.camera));
  const Renderer renderer(
      std::make_shared<const World>(1, options.world, 1), camera, options.sensor.samples, 1);
  std::vector<cv::Mat> images;
  for (int i = 0; i < 8; ++i) {
    ImageSensor sensor(options.sensor, *camera, 1);
    images.push_back(
        sensor.Expose(renderer.RenderRadiance(LookAlong(renderer.world(), 0.785 * i))));
  }
  return images;
}

double ShareDarkerThan(int grey, const std::vector<cv::Mat>& images) {
  double dark = 0;
  for (const cv::Mat& image : images) {
    dark += cv::countNonZero(image < grey) / static_cast<double>(image.total());
  }
  return dark / static_cast<double>(images.size());
}

TEST(World, ADarkHallIsBlackInLargePartAndHasCornersElsewhere) {
  const std::vector<cv::Mat> dark = PhotographHall("dark");
  EXPECT_GT(ShareDarkerThan(48, dark), 0.3);
  EXPECT_LT(ShareDarkerThan(48, PhotographHall("hall")), 0.1);
  for (const cv::Mat& image : dark) {
    std::vector<cv::KeyPoint> corners;
    cv::FAST(image, corners, 20);
    EXPECT_GT(corners.size(), 200U);
  }
}

TEST(World, RejectsInvalidOptions) {
  WorldOptions options;
  options.height_m = 1.0;
  EXPECT_THROW(World(1, options, 1), CheckError);
}

}  // namespace
}  // namespace deja_view::sim
