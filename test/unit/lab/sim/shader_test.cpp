#include "deja_view/lab/sim/shader.hpp"

#include <cmath>

#include "instruction_sets.hpp"
#include "scene_builders.hpp"
#include "small_world.hpp"
#include <gtest/gtest.h>

namespace deja_view::sim {
namespace {

class ShaderTest : public ::testing::Test {
 protected:
  ShaderTest() : scene_(TinyWorld()->scene()), caster_(scene_, LookAlong(*TinyWorld(), 0.0)) {}

  RayPacket RandomPacket(Rng* rng) {
    RayPacket packet;
    const Eigen::Vector3f axis = RandomDirection(rng);
    for (int i = 0; i < RayPacket::kSize; ++i) {
      const Eigen::Vector3f ray = (axis + 0.2F * RandomDirection(rng)).normalized();
      packet.x[i] = ray.x();
      packet.y[i] = ray.y();
      packet.z[i] = ray.z();
    }
    caster_.Trace(caster_.visible(), &packet);
    caster_.Complete(&packet);
    return packet;
  }

  const Scene& scene_;
  BeamCaster caster_;
};

TEST_F(ShaderTest, AgreesWithTheReference) {
  Rng rng(1, 0);
  for (const float sample_angle : {0.0005F, 0.004F, 0.05F, 5.0F}) {
    const Shader shader(scene_, sample_angle);
    for (int i = 0; i < 200; ++i) {
      const RayPacket packet = RandomPacket(&rng);
      const Shader::Lanes radiance = shader.Shade(packet);
      for (int lane = 0; lane < RayPacket::kSize; ++lane) {
        // The two round the texture coordinates of a large wall differently.
        EXPECT_NEAR(radiance[lane], shader.ShadeOne(packet, lane), 3e-3);
      }
    }
  }
}

TEST_F(ShaderTest, InstructionSetsAgreeToTheBit) {
  Rng rng(2, 0);
  const Shader shader(scene_, 0.003F);
  for (int i = 0; i < 200; ++i) {
    const RayPacket packet = RandomPacket(&rng);
    const Shader::Lanes expected = shader.Shade(packet);
    test::OnEveryInstructionSet([&] { EXPECT_EQ(shader.Shade(packet), expected); });
  }
}

TEST_F(ShaderTest, ARayIntoNothingIsBlackAndALampShinesByItself) {
  Scene scene;
  scene.textures.push_back(MakePlainTexture(0.25F));
  scene.surfaces.push_back(MakeSquare({0, 0, 2}, -Eigen::Vector3f::UnitZ(), 1));
  scene.surfaces.push_back(MakeSquare({1, 0, 2}, -Eigen::Vector3f::UnitZ(), 0.5F));
  scene.surfaces[1].emission = 7.0F;
  for (Surface& surface : scene.surfaces) {
    surface.light_u = surface.light_v = 2;
  }
  scene.light.assign(4, 2.0F);
  const BeamCaster caster(scene, Rigid3());
  RayPacket packet;
  packet.z.fill(1.0F);
  packet.x[1] = 0.447214F;  // towards (1, 0, 2)
  packet.z[1] = 0.894427F;
  packet.z[2] = -1.0F;
  caster.Trace(caster.visible(), &packet);
  caster.Complete(&packet);
  const Shader::Lanes radiance = Shader(scene, 0.001F).Shade(packet);
  EXPECT_NEAR(radiance[0], 0.5, 5e-3);
  EXPECT_EQ(radiance[1], 7.0F);
  EXPECT_EQ(radiance[2], 0.0F);
}

TEST_F(ShaderTest, AGlossySurfaceMirrorsALampUnlessSomethingStandsBeforeIt) {
  Scene scene;
  scene.textures.push_back(MakePlainTexture(0.0F));
  scene.surfaces.push_back(MakeSquare({0, 0, 2}, -Eigen::Vector3f::UnitZ(), 4));
  scene.surfaces.push_back(MakeSquare({3, 0, 0}, Eigen::Vector3f::UnitZ(), 0.4F));
  scene.surfaces[1].emission = 7.0F;
  for (Surface& surface : scene.surfaces) {
    surface.light_u = surface.light_v = 2;
  }
  scene.light.assign(4, 0.0F);
  RayPacket packet;
  packet.z.fill(1.0F);
  packet.x[1] = 0.6F;  // meets (1.5, 0, 2), and from there the lamp
  packet.z[1] = 0.8F;
  const auto shade = [&] {
    const BeamCaster caster(scene, Rigid3());
    caster.Trace(caster.visible(), &packet);
    caster.Complete(&packet);
    return Shader(scene, 0.001F).Shade(packet);
  };
  EXPECT_EQ(shade()[1], 0.0F);
  scene.surfaces[0].gloss = 0.05F;
  const float schlick = 0.05F + 0.95F * std::pow(0.2F, 5.0F);
  EXPECT_NEAR(shade()[1], 7.0F * schlick, 1e-4);
  EXPECT_EQ(shade()[0], 0.0F);
  scene.surfaces.push_back(MakeSquare({2.25F, 0, 1}, Eigen::Vector3f::UnitZ(), 0.4F));
  scene.surfaces[2].light_u = scene.surfaces[2].light_v = 2;
  EXPECT_EQ(shade()[1], 0.0F);
}

}  // namespace
}  // namespace deja_view::sim
