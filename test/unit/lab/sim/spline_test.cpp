#include "deja_view/lab/sim/spline.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/lab/sim/random.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace deja_view::sim {
namespace {

using Value = QuinticSpline::Value;

QuinticSpline RandomSpline() {
  Rng rng(1, 2);
  std::vector<Value> points;
  for (int i = 0; i < 14; ++i) {
    points.emplace_back(rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal());
  }
  return {points, 0.5};
}

TEST(QuinticSpline, ReproducesALine) {
  std::vector<Value> points;
  for (int i = 0; i < 10; ++i) {
    points.emplace_back(Value(1, 2, -3, 4) * i + Value::Constant(7));
  }
  const QuinticSpline spline(points, 0.25);
  EXPECT_DOUBLE_EQ(spline.duration(), 1.25);
  for (const double t : {0.0, 0.1, 0.6, 1.25}) {
    // Point i acts most at i - 2 steps.
    EXPECT_LT(
        (spline.Evaluate(t, 0) - (Value(1, 2, -3, 4) * (t / 0.25 + 2) + Value::Constant(7))).norm(),
        1e-12);
    EXPECT_LT((spline.Evaluate(t, 1) - Value(1, 2, -3, 4) / 0.25).norm(), 1e-11);
    EXPECT_LT(spline.Evaluate(t, 2).norm(), 1e-10);
  }
}

TEST(QuinticSpline, DerivativesMatchDifferences) {
  const QuinticSpline spline = RandomSpline();
  constexpr double kDelta = 1e-5;
  for (int order = 0; order < 3; ++order) {
    for (double t = 0.1; t < spline.duration() - 0.1; t += 0.173) {
      const Value numeric =
          (spline.Evaluate(t + kDelta, order) - spline.Evaluate(t - kDelta, order)) / (2 * kDelta);
      EXPECT_LT((numeric - spline.Evaluate(t, order + 1)).norm(), 1e-6 * (1 + numeric.norm()));
    }
  }
}

TEST(QuinticSpline, IsSmoothAtKnots) {
  const QuinticSpline spline = RandomSpline();
  for (int order = 0; order <= 3; ++order) {
    for (double knot = 0.5; knot < spline.duration(); knot += 0.5) {
      const Value jump = spline.Evaluate(knot + 1e-9, order) - spline.Evaluate(knot - 1e-9, order);
      EXPECT_LT(jump.norm(), 1e-5);
    }
  }
}

TEST(QuinticSpline, WantsSixPoints) {
  EXPECT_THROW(QuinticSpline(std::vector<Value>(5), 0.5), CheckError);
}

}  // namespace
}  // namespace deja_view::sim
