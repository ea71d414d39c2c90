#include "ray_tracer.hpp"

#include "deja_view/nerf/kernels.hpp"

#include <cmath>
#include <random>

#include "closed_form.hpp"
#include <gtest/gtest.h>

namespace deja_view::nerf::internal {
namespace {

Trace TraceAll(const RadianceField& field, const std::vector<Ray>& rays) {
  RayTracer tracer(field, PortableKernels());
  Trace trace;
  tracer.Run(rays, {field.march, 1.0F}, &trace);
  return trace;
}

TEST(RayTracer, SlabOfConstantDensityDimsAsTheExponential) {
  constexpr double kSigma = 0.7;
  const RadianceField field = ConstantField(kSigma, 0.4F);
  const Trace trace = TraceAll(field, {MakeRay(field, {-5, 0.3, 0.2}, {1, 0, 0}, 0.5F)});
  EXPECT_NEAR(trace.transmittance[0], std::exp(-kSigma * 4), 1e-4);
  double weight = 0;
  double radiance = 0;
  double depth = 0;
  for (std::size_t s = 0; s < trace.size(); ++s) {
    const auto w = static_cast<double>(trace.weight[s]);
    weight += w;
    radiance += w * static_cast<double>(trace.color[s]);
    depth += w * static_cast<double>(trace.t[s]) * field.box.Size();
  }
  EXPECT_LE(weight, 1 + 1e-6);
  EXPECT_NEAR(radiance, 0.4 * (1 - std::exp(-kSigma * 4)), 1e-4);
  // Mean of t over an exponential cut off behind 4 m, from the face 4 m away.
  const double out = std::exp(-kSigma * 4);
  EXPECT_NEAR(depth / weight, 4 + 1 / kSigma - 4 * out / (1 - out), 1e-3);
}

TEST(RayTracer, EmptySpaceGivesNoSample) {
  RadianceField field = ConstantField(5, 0.4F);
  field.occupancy.SetWords(std::vector<std::uint64_t>(field.occupancy.words().size(), 0));
  const Trace trace = TraceAll(field, {MakeRay(field, {-5, 0.3, 0.2}, {1, 0, 0}, 0.5F)});
  EXPECT_EQ(trace.size(), std::size_t{0});
  EXPECT_EQ(trace.evaluated, std::size_t{0});
  EXPECT_EQ(trace.transmittance[0], 1.0F);
}

TEST(RayTracer, MissesWhatIsNotInTheWay) {
  const RadianceField field = ConstantField(5, 0.4F);
  const Trace trace = TraceAll(
      field,
      {MakeRay(field, {-5, 7, 0}, {1, 0, 0}, 0.5F), MakeRay(field, {-5, 0, 0}, {-1, 0, 0}, 0.5F)});
  EXPECT_EQ(trace.size(), std::size_t{0});
}

// A ball of cells: a ray ends at its surface, to a cell.
TEST(RayTracer, OpaqueSphereIsHitAtItsSurface) {
  RadianceField field = ConstantField(1000, 0.6F);
  const Eigen::Vector3d centre(1, 0.5, 0);
  constexpr double kRadius = 0.7;
  const double cell = field.box.Size() / static_cast<double>(field.occupancy.scale());
  for (std::size_t i = 0; i < field.occupancy.cell_count(); ++i) {
    const auto [x, y, z] = field.occupancy.Cell(i);
    const Eigen::Vector3d middle =
        field.box.min + cell * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
    field.occupancy.Set(i, (middle - centre).norm() < kRadius);
  }
  std::mt19937 rng(2);
  std::uniform_real_distribution<double> uniform(-0.4, 0.4);
  std::vector<Ray> rays;
  std::vector<double> expected;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d origin(-3, uniform(rng), uniform(rng));
    const Eigen::Vector3d aim = centre + Eigen::Vector3d(0, uniform(rng), uniform(rng));
    const Eigen::Vector3d direction = (aim - origin).normalized();
    const double along = (centre - origin).dot(direction);
    const double off2 = (centre - origin).squaredNorm() - along * along;
    expected.push_back(along - std::sqrt(kRadius * kRadius - off2));
    rays.push_back(MakeRay(field, origin, direction, 0.5F));
  }
  const Trace trace = TraceAll(field, rays);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    EXPECT_LT(trace.transmittance[r], 1e-6F);
    const double t = static_cast<double>(trace.t[trace.ray_begin[r]]) * field.box.Size();
    EXPECT_NEAR(t, expected[r], 2 * cell);
  }
}

// Lengths of hundreds have no bits left for steps of a millionth.
TEST(RayTracer, FarCamerasSeeWhatNearOnesDo) {
  RadianceField field = ConstantField(3, 0.4F);
  for (std::size_t i = 0; i < field.occupancy.cell_count(); ++i) {
    field.occupancy.Set(i, field.occupancy.Cell(i)[0] % 3 == 1);
  }
  const Eigen::Vector3d aim(1, 0.5, 0);
  for (const Eigen::Vector3d& from : {Eigen::Vector3d(-1, 0.2, 0.1),
                                      Eigen::Vector3d(-1, 0.3, 1e-4),
                                      Eigen::Vector3d(1e-3, -1, 1e-7)}) {
    const Eigen::Vector3d back = from.normalized() * field.box.Size();
    const Ray near_ray = MakeRay(field, aim + 2 * back, -back.normalized(), 0.5F);
    const float light = TraceAll(field, {near_ray}).transmittance[0];
    for (const double boxes : {50.0, 200.0, 1e4, 1e9}) {
      const Trace trace =
          TraceAll(field, {MakeRay(field, aim + boxes * back, -back.normalized(), 0.5F)});
      EXPECT_NEAR(trace.transmittance[0], light, 0.02F) << boxes;
    }
  }
}

TEST(RayTracer, WeightsSumToAtMostOne) {
  const RadianceField untrained(SmallFieldOptions(), {}, ConstantField(1, 0.5F).box, 1, 5);
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Ray> rays;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d direction(uniform(rng), uniform(rng), uniform(rng));
    rays.push_back(MakeRay(untrained, {0.1, 0.2, 0.3}, direction.normalized(), 0.3F));
  }
  const Trace trace = TraceAll(untrained, rays);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    float sum = 0;
    for (std::size_t s = trace.ray_begin[r]; s < trace.ray_begin[r + 1]; ++s) {
      EXPECT_EQ(trace.ray[s], r);
      EXPECT_TRUE(s == trace.ray_begin[r] || trace.t[s] > trace.t[s - 1]);
      sum += trace.weight[s];
    }
    EXPECT_LE(sum, 1 + 1e-5F);
    EXPECT_NEAR(sum + trace.transmittance[r], 1, 0.3);
  }
}

}  // namespace
}  // namespace deja_view::nerf::internal
