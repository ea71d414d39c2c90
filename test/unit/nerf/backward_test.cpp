#include "backward.hpp"

#include "deja_view/nerf/kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "closed_form.hpp"
#include "grid_optimizer.hpp"
#include <gtest/gtest.h>

namespace deja_view::nerf::internal {
namespace {

/// A field with some structure, rays through it, and its loss by all terms at once.
class Scene {
 public:
  explicit Scene(int channels, bool far_background = true)
      : field(Options(far_background), March(), ConstantField(1, 0.5F).box, channels, 7) {
    std::mt19937 rng(4);
    std::uniform_real_distribution<float> uniform(-1, 1);
    for (FeatureGrid* grid : {&field.geometry, &field.appearance, &field.background}) {
      for (std::size_t i = 0; i < grid->parameters().size(); ++i) {
        grid->parameters()[i] = uniform(rng);
      }
    }
    field.density.OutputBias(0) = 1;
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector3d direction(static_cast<double>(uniform(rng)),
                                      static_cast<double>(uniform(rng)),
                                      static_cast<double>(uniform(rng)));
      rays.push_back(MakeRay(field, {0.4, 0.3, 0.1}, direction.normalized(), 0.4F));
      RayTarget target;
      target.color = {0.2F, 0.9F, 0.4F};
      target.range = i >= 4 ? 0.2F : 0.0F;
      target.vignetting = 0.8F;
      rays.back().latent = latent.data();
      targets.push_back(target);
    }
    loss_options = {0.2F, 0.3F, 0.5F};
  }

  static FieldOptions Options(bool far_background) {
    FieldOptions options = SmallFieldOptions();
    options.far_background = far_background;
    options.background = {2, 4, 9, 4, 8};
    options.latent_size = 3;
    return options;
  }

  static MarchOptions March() {
    MarchOptions march = ConstantField(1, 0.5F).march;
    march.min_step = march.max_step = 1.0F / 64;
    return march;
  }

  double Loss() {
    Trace trace;
    LossGradient loss;
    Evaluate(&trace, &loss);
    return loss.loss;
  }

  void Evaluate(Trace* trace, LossGradient* loss) {
    RayTracer tracer(field, PortableKernels());
    tracer.Run(rays, {field.march, 1.0F}, trace);
    ComputeLoss(field, *trace, targets, exposures, loss_options, loss);
  }

  ChunkGradient Gradient() {
    Trace trace;
    LossGradient loss;
    Evaluate(&trace, &loss);
    BackwardScratch scratch;
    ChunkGradient gradient;
    Backpropagate(field, PortableKernels(), loss, &trace, &scratch, &gradient);
    return gradient;
  }

  /// Central difference of the loss; the networks' transposes play no part in it.
  double Difference(float* value, float step) {
    const float before = *value;
    *value = before + step;
    const double above = Loss();
    *value = before - step;
    const double below = Loss();
    *value = before;
    return (above - below) / (2 * static_cast<double>(step));
  }

  RadianceField field;
  std::array<float, 3> latent = {0.3F, -0.2F, 0.5F};
  std::vector<Ray> rays;
  std::vector<RayTarget> targets;
  std::vector<GainBias> exposures = {{1.2F, -0.05F}};
  LossOptions loss_options;
};

void ExpectClose(double found, double expected) {
  EXPECT_NEAR(found, expected, 5e-5 + 0.03 * std::abs(expected));
}

class BackwardTest : public testing::TestWithParam<int> {};

TEST_P(BackwardTest, NetworkGradientsAgreeWithDifferences) {
  Scene scene(GetParam());
  const ChunkGradient gradient = scene.Gradient();
  for (std::size_t i = 0; i < gradient.density_network.size(); i += 11) {
    if (gradient.density_network[i] != 0) {
      ExpectClose(static_cast<double>(gradient.density_network[i]),
                  scene.Difference(&scene.field.density.parameters()[i], 3e-3F));
    }
  }
  for (std::size_t i = 0; i < gradient.color_network.size(); i += 11) {
    if (gradient.color_network[i] != 0) {
      ExpectClose(static_cast<double>(gradient.color_network[i]),
                  scene.Difference(&scene.field.color.parameters()[i], 3e-3F));
    }
  }
}

TEST_P(BackwardTest, WithABackdropGradientsAgreeWithDifferences) {
  Scene scene(GetParam(), false);
  scene.loss_options.opaque = true;
  for (std::size_t r = 0; r < scene.targets.size(); ++r) {
    scene.targets[r].color = {0, 0, 0};
    scene.targets[r].backdrop = 0.15F * static_cast<float>(r + 1);
  }
  const ChunkGradient gradient = scene.Gradient();
  int checked = 0;
  for (std::size_t i = 0; i < gradient.density_network.size(); i += 7) {
    if (std::abs(gradient.density_network[i]) > 1e-4F) {
      ExpectClose(static_cast<double>(gradient.density_network[i]),
                  scene.Difference(&scene.field.density.parameters()[i], 3e-3F));
      ++checked;
    }
  }
  EXPECT_GT(checked, 3);
}

TEST(Backdrop, IsTheDigitsOfTheJitterThatMoveNoSample) {
  EXPECT_FLOAT_EQ(BackdropOf(0.0F), 0.0F);
  EXPECT_FLOAT_EQ(BackdropOf(0.5F), 0.0F);
  EXPECT_FLOAT_EQ(BackdropOf(0.5F + 0.25F / 1024), 0.25F);
}

TEST_P(BackwardTest, GridGradientsAgreeWithDifferences) {
  Scene scene(GetParam());
  const ChunkGradient gradient = scene.Gradient();
  const auto check = [&](FeatureGrid* grid, const GridGradient& samples) {
    for (std::size_t l = 0; l < samples.levels.size(); ++l) {
      const GridLevel& level = grid->levels()[l];
      std::vector<float> sums(
          std::size_t{8} * level.bricks * static_cast<std::size_t>(level.features), 0.0F);
      std::vector<std::uint8_t> touched(level.bricks, 0);
      PortableKernels().grid_backward(level,
                                      samples.positions(),
                                      samples.size(),
                                      samples.levels[l].data(),
                                      sums.data(),
                                      touched.data());
      float largest = 0;
      for (const float sum : sums) {
        largest = std::max(largest, std::abs(sum));
      }
      ASSERT_GT(largest, 1e-4F);
      int checked = 0;
      for (std::size_t i = 0; i < sums.size() && checked < 8; ++i) {
        if (std::abs(sums[i]) > 0.4F * largest) {
          ExpectClose(static_cast<double>(sums[i]),
                      scene.Difference(&grid->parameters()[level.offset + i], 5e-3F));
          ++checked;
        }
      }
      EXPECT_GT(checked, 0) << "level " << l;
    }
  };
  check(&scene.field.geometry, gradient.geometry);
  check(&scene.field.appearance, gradient.appearance);
  check(&scene.field.background, gradient.background);
}

TEST_P(BackwardTest, ExposureGradientsAgreeWithDifferences) {
  Scene scene(GetParam());
  Trace trace;
  LossGradient loss;
  scene.Evaluate(&trace, &loss);
  double gain = 0;
  double bias = 0;
  for (const GainBias& d : loss.d_exposure) {
    gain += static_cast<double>(d.gain);
    bias += static_cast<double>(d.bias);
  }
  ExpectClose(gain, scene.Difference(&scene.exposures[0].gain, 1e-3F));
  ExpectClose(bias, scene.Difference(&scene.exposures[0].bias, 1e-3F));
}

TEST_P(BackwardTest, BackgroundNetworkGradientsAgreeWithDifferences) {
  Scene scene(GetParam());
  const ChunkGradient gradient = scene.Gradient();
  int checked = 0;
  for (std::size_t i = 0; i < gradient.background_network.size(); i += 7) {
    if (std::abs(gradient.background_network[i]) > 1e-3F) {
      ExpectClose(static_cast<double>(gradient.background_network[i]),
                  scene.Difference(&scene.field.background_color.parameters()[i], 3e-3F));
      ++checked;
    }
  }
  EXPECT_GT(checked, 3);
}

TEST_P(BackwardTest, LatentGradientsAgreeWithDifferences) {
  Scene scene(GetParam());
  const ChunkGradient gradient = scene.Gradient();
  const std::size_t size = scene.latent.size();
  ASSERT_EQ(gradient.latent.size(), scene.rays.size() * size);
  for (std::size_t i = 0; i < size; ++i) {
    double sum = 0;
    for (std::size_t r = 0; r < scene.rays.size(); ++r) {
      sum += static_cast<double>(gradient.latent[r * size + i]);
    }
    EXPECT_GT(std::abs(sum), 1e-4);
    ExpectClose(sum, scene.Difference(&scene.latent[i], 3e-3F));
  }
}

INSTANTIATE_TEST_SUITE_P(Channels, BackwardTest, testing::Values(1, 3));

}  // namespace
}  // namespace deja_view::nerf::internal
