#include "backward.hpp"

#include <algorithm>
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
  explicit Scene(int channels)
      : field(SmallFieldOptions(), March(), ConstantField(1, 0.5F).box, channels, 7) {
    std::mt19937 rng(4);
    std::uniform_real_distribution<float> uniform(-1, 1);
    for (FeatureGrid* grid : {&field.geometry, &field.appearance}) {
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
      target.is_depth = i == 5;
      target.color = {0.2F, 0.9F, 0.4F};
      target.range = 0.2F;
      targets.push_back(target);
    }
    loss_options = {0.2F, 0.3F, 0.5F};
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

TEST_P(BackwardTest, GridGradientsAgreeWithDifferences) {
  Scene scene(GetParam());
  const ChunkGradient gradient = scene.Gradient();
  const auto check = [&](FeatureGrid* grid, const std::vector<std::vector<float>>& levels) {
    for (std::size_t l = 0; l < levels.size(); ++l) {
      const GridLevel& level = grid->levels()[l];
      std::vector<float> sums(
          std::size_t{8} * level.bricks * static_cast<std::size_t>(level.features), 0.0F);
      std::vector<std::uint8_t> touched(level.bricks, 0);
      PortableKernels().grid_backward(level,
                                      gradient.positions(),
                                      gradient.size(),
                                      levels[l].data(),
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
  check(&scene.field.geometry, gradient.geometry_levels);
  check(&scene.field.appearance, gradient.appearance_levels);
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

INSTANTIATE_TEST_SUITE_P(Channels, BackwardTest, testing::Values(1, 3));

}  // namespace
}  // namespace deja_view::nerf::internal
