#include "deja_view/lab/sim/beam_caster.hpp"

#include <algorithm>
#include <cmath>

#include "instruction_sets.hpp"
#include "scene_builders.hpp"
#include <gtest/gtest.h>

namespace deja_view::sim {
namespace {

using Eigen::Vector3f;

const Rigid3 kPose{ExpSo3({0.3, -0.8, 0.5}), {0.2, -0.3, 0.1}};

RayPacket PacketAround(const Vector3f& axis, float spread, Rng* rng) {
  RayPacket packet;
  for (int i = 0; i < RayPacket::kSize; ++i) {
    const Vector3f ray = (axis + spread * RandomDirection(rng)).normalized();
    packet.x[i] = ray.x();
    packet.y[i] = ray.y();
    packet.z[i] = ray.z();
  }
  return packet;
}

Vector3f Direction(const RayPacket& packet, int lane) {
  return {packet.x[lane], packet.y[lane], packet.z[lane]};
}

TEST(BeamCaster, FindsWhatTheReferenceFinds) {
  const Scene scene = MakeClutter(120, 1);
  const BeamCaster caster(scene, kPose);
  Rng rng(5, 0);
  int hits = 0;
  int differences = 0;
  for (int i = 0; i < 200; ++i) {
    RayPacket packet = PacketAround(RandomDirection(&rng), 0.3F, &rng);
    caster.Trace(caster.visible(), &packet);
    caster.Complete(&packet);
    for (int lane = 0; lane < RayPacket::kSize; ++lane) {
      const Vector3f direction = Direction(packet, lane);
      const auto expected = CastRay(scene, kPose.t, kPose.q * direction.cast<double>());
      if ((expected ? expected->surface : -1) != packet.surface[lane]) {
        ++differences;  // a ray that grazes an edge
        continue;
      }
      if (expected) {
        ++hits;
        EXPECT_NEAR(packet.range[lane], expected->range, 1e-4 * expected->range);
        EXPECT_NEAR(packet.v[lane], expected->v, 2e-3);
        EXPECT_NEAR(packet.u[lane], expected->u, 5e-3);
        const auto& surface = scene.surfaces[static_cast<std::size_t>(expected->surface)];
        EXPECT_NEAR(
            packet.cosine[lane],
            -(kPose.q * direction.cast<double>()).cast<float>().dot(surface.NormalAt(expected->u)),
            1e-4);
      } else {
        EXPECT_TRUE(std::isinf(packet.range[lane]));
      }
    }
  }
  EXPECT_GT(hits, 800);
  EXPECT_LE(differences, 6);
}

TEST(BeamCaster, InstructionSetsAgreeToTheBit) {
  const Scene scene = MakeClutter(90, 2);
  const BeamCaster caster(scene, kPose);
  Rng rng(6, 0);
  for (int i = 0; i < 100; ++i) {
    const RayPacket rays = PacketAround(RandomDirection(&rng), 0.2F, &rng);
    RayPacket expected = rays;
    caster.Trace(caster.visible(), &expected);
    test::OnEveryInstructionSet([&] {
      RayPacket packet = rays;
      caster.Trace(caster.visible(), &packet);
      EXPECT_EQ(packet.surface, expected.surface);
      EXPECT_EQ(packet.range, expected.range);
      for (int lane = 0; lane < RayPacket::kSize; ++lane) {
        if (packet.surface[lane] >= 0) {
          EXPECT_EQ(packet.u[lane], expected.u[lane]);
          EXPECT_EQ(packet.v[lane], expected.v[lane]);
        }
      }
    });
  }
}

TEST(BeamCaster, CullingLosesNothingAndHelps) {
  const Scene scene = MakeClutter(150, 3);
  const BeamCaster caster(scene, kPose);
  Rng rng(7, 0);
  std::size_t kept = 0;
  constexpr int kBeams = 300;
  for (int i = 0; i < kBeams; ++i) {
    RayPacket all = PacketAround(RandomDirection(&rng), 0.1F, &rng);
    std::vector<Vector3f> directions;
    for (int lane = 0; lane < RayPacket::kSize; ++lane) {
      directions.push_back(Direction(all, lane));
    }
    std::vector<std::int32_t> candidates;
    caster.Cull(BoundingCone(directions, 1e-4F), caster.visible(), &candidates);
    kept += candidates.size();
    RayPacket culled = all;
    caster.Trace(caster.visible(), &all);
    caster.Trace(candidates, &culled);
    EXPECT_EQ(all.surface, culled.surface);
    EXPECT_EQ(all.range, culled.range);
  }
  EXPECT_LT(kept, kBeams * caster.visible().size() / 8);
}

TEST(BeamCaster, KeepsItsDigitsForAThinPipeFarAway) {
  Scene scene;
  scene.surfaces.push_back(MakeCylinder({30, 0, -2}, Vector3f::UnitZ(), 0.05F, 4));
  const BeamCaster caster(scene, Rigid3());
  Rng rng(8, 0);
  RayPacket packet = PacketAround(Vector3f::UnitX(), 0.0F, &rng);
  for (int lane = 0; lane < RayPacket::kSize; ++lane) {
    packet.y[lane] = 0.0015F * (static_cast<float>(lane) / 15.0F - 0.5F);
  }
  caster.Trace(caster.visible(), &packet);
  for (int lane = 0; lane < RayPacket::kSize; ++lane) {
    const auto expected =
        CastRay(scene, Eigen::Vector3d::Zero(), Direction(packet, lane).cast<double>());
    ASSERT_TRUE(expected);
    EXPECT_NEAR(packet.range[lane], expected->range, 2e-4);
  }
}

TEST(BoundingCone, HoldsItsDirections) {
  const std::vector<Vector3f> directions = {Vector3f::UnitZ(), Vector3f(0.6F, 0, 0.8F)};
  const Cone cone = BoundingCone(directions, 0.0F);
  const float half_angle = 0.5F * std::atan2(0.6F, 0.8F);
  EXPECT_NEAR(cone.sin_half_angle, std::sin(half_angle), 1e-6);
  EXPECT_NEAR(cone.axis.dot(directions[0]), std::cos(half_angle), 1e-6);
}

}  // namespace
}  // namespace deja_view::sim
