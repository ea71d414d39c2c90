#include "deja_view/lab/sim/light.hpp"

#include "scene_builders.hpp"
#include <gtest/gtest.h>

namespace deja_view::sim {
namespace {

using Eigen::Vector3f;

LightSource LampAt(const Vector3f& p, float intensity) {
  LightSource lamp;
  lamp.points = {p};
  lamp.intensity = intensity;
  return lamp;
}

float LightBelow(const Scene& scene, float x, float y) {
  const Surface& floor = scene.surfaces.front();
  const Vector3f p = Vector3f(x, y, 0) - floor.origin;
  return SampleLight(scene, floor, floor.axis_u.dot(p), floor.axis_v.dot(p));
}

TEST(BakeLight, FollowsTheInverseSquareLaw) {
  Scene scene;
  scene.surfaces.push_back(MakeSquare(Vector3f::Zero(), Vector3f::UnitZ(), 8));
  Scene dark = scene;
  BakeLight({LampAt({0, 0, 2}, 3)}, 0.1, 1, &scene);
  BakeLight({}, 0.1, 1, &dark);
  const float ambient = LightBelow(dark, 0, 0);
  EXPECT_GT(ambient, 0.0F);
  EXPECT_NEAR(LightBelow(scene, 0, 0) - ambient, 3.0 / (4.0 + 0.5), 1e-2);
  // Distance^2 = 8, both cosines 1/sqrt(2), the lamp's under a root.
  EXPECT_NEAR(LightBelow(scene, 2, 0) - ambient, 3.0 * 0.7071 * 0.8409 / (8.0 + 0.5), 1e-2);
}

TEST(BakeLight, ThingsThrowShadows) {
  Scene scene;
  scene.surfaces.push_back(MakeSquare(Vector3f::Zero(), Vector3f::UnitZ(), 8));
  scene.surfaces.push_back(MakeSquare({0, 0, 1.8F}, Vector3f::UnitZ(), 1));  // seen by the lamp
  BakeLight({LampAt({0, 0, 3}, 3)}, 0.1, 1, &scene);
  Scene open = scene;
  open.surfaces.pop_back();
  BakeLight({LampAt({0, 0, 3}, 3)}, 0.1, 1, &open);
  // The umbra of the 1 m square reaches 1.25 m from the middle.
  EXPECT_LT(LightBelow(scene, 1.1F, 0), 0.4F);
  EXPECT_NEAR(LightBelow(scene, 1.5F, 0), LightBelow(open, 1.5F, 0), 0.02);
  EXPECT_GT(LightBelow(open, 1.1F, 0), 0.5F);
}

TEST(BakeLight, CornersAreDimmer) {
  Scene scene;
  scene.surfaces.push_back(MakeSquare(Vector3f::Zero(), Vector3f::UnitZ(), 8));
  scene.surfaces.push_back(MakeSquare({4, 0, 4}, -Vector3f::UnitX(), 8));
  BakeLight({}, 0.1, 1, &scene);
  EXPECT_LT(LightBelow(scene, 3.8F, 0), 0.85F * LightBelow(scene, 0, 0));
}

TEST(BakeLight, IsTheSameOnAnyNumberOfThreads) {
  Scene a = MakeClutter(30, 4);
  Scene b = a;
  const std::vector<LightSource> lamps = {LampAt({0, 0, 3}, 2), LampAt({1, 2, 3}, 1)};
  BakeLight(lamps, 0.2, 1, &a);
  BakeLight(lamps, 0.2, 3, &b);
  EXPECT_EQ(a.light, b.light);
}

}  // namespace
}  // namespace deja_view::sim
