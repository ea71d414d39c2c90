#include "deja_view/views/view_sampling.hpp"

#include <cmath>
#include <limits>
#include <set>

#include <gmock/gmock.h>

namespace deja_view {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr std::int64_t kStamp = 1403636632538560256;

SamplingOptions Wide() {
  SamplingOptions options;
  options.views = 6;
  options.radius_m = 0.8;
  options.min_radius_m = 0.3;
  options.spacing_min_m = 0.25;
  options.spacing_max_m = 0.7;
  options.rotation_deg = 30;
  return options;
}

double NearestNeighbour(const std::vector<Rigid3>& views, std::size_t i) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < views.size(); ++j) {
    if (j != i) {
      nearest = std::min(nearest, (views[i].t - views[j].t).norm());
    }
  }
  return nearest;
}

void ExpectInvariants(const SamplingOptions& options, const std::vector<Rigid3>& views) {
  const double half = 0.5 * options.rotation_deg * M_PI / 180;
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_LE(views[i].t.norm(), options.radius_m);
    EXPECT_GE(views[i].t.norm(), options.min_radius_m);
    EXPECT_LE(LogSo3(views[i].q).cwiseAbs().maxCoeff(), half + 1e-12);
    if (views.size() > 1) {
      EXPECT_GE(NearestNeighbour(views, i), options.spacing_min_m);
      EXPECT_LE(NearestNeighbour(views, i), options.spacing_max_m);
    }
  }
}

TEST(ViewSamplingTest, KeepsDistancesRadiusAndRotation) {
  for (const SamplingOptions& options : {SamplingOptions(), Wide()}) {
    std::size_t total = 0;
    for (int i = 0; i < 200; ++i) {
      const std::vector<Rigid3> views = SampleViews(options, kStamp + i, nullptr);
      ExpectInvariants(options, views);
      total += views.size();
    }
    EXPECT_EQ(total, 200U * static_cast<std::size_t>(options.views));
  }
}

TEST(ViewSamplingTest, FillsBallAndRotationRange) {
  const SamplingOptions options = Wide();
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  Eigen::Vector3d high = Eigen::Vector3d::Zero();
  double largest = 0;
  for (int i = 0; i < 200; ++i) {
    for (const Rigid3& view : SampleViews(options, kStamp + i, nullptr)) {
      low = low.cwiseMin(view.t);
      high = high.cwiseMax(view.t);
      largest = std::max(largest, LogSo3(view.q).cwiseAbs().maxCoeff());
    }
  }
  EXPECT_LT(low.maxCoeff(), -0.7);
  EXPECT_GT(high.minCoeff(), 0.7);
  EXPECT_GT(largest, 0.98 * 15 * M_PI / 180);
}

TEST(ViewSamplingTest, DependsOnSeedAndStampAlone) {
  SamplingOptions options = Wide();
  const auto positions = [&options](std::int64_t stamp_ns) {
    std::vector<double> result;
    for (const Rigid3& view : SampleViews(options, stamp_ns, nullptr)) {
      result.insert(result.end(), {view.t.x(), view.q.x()});
    }
    return result;
  };
  const std::vector<double> first = positions(kStamp);
  EXPECT_NE(first, positions(kStamp + 1));
  EXPECT_EQ(first, positions(kStamp));
  options.seed = 2;
  EXPECT_NE(first, positions(kStamp));
}

TEST(ViewSamplingTest, ReplacesPosesThatAreNotAccepted) {
  const SamplingOptions options = Wide();
  const auto is_ahead = [](const Rigid3& T_C_V) { return T_C_V.t.z() > 0; };
  const std::vector<Rigid3> views = SampleViews(options, kStamp, is_ahead);
  EXPECT_GE(views.size(), 3U);
  for (const Rigid3& view : views) {
    EXPECT_GT(view.t.z(), 0);
  }
  ExpectInvariants(options, views);
  EXPECT_THAT(SampleViews(options, kStamp, [](const Rigid3&) { return false; }), SizeIs(0));
}

TEST(ViewSamplingTest, GivesFewerViewsWhereTheBallIsFull) {
  SamplingOptions options;
  options.views = 100;
  options.radius_m = 0.02;
  options.spacing_min_m = 0.019;
  options.spacing_max_m = 0.05;
  const std::vector<Rigid3> views = SampleViews(options, kStamp, nullptr);
  EXPECT_GE(views.size(), 3U);
  EXPECT_LE(views.size(), 13U);  // as spheres touch one another
  ExpectInvariants(options, views);
}

std::vector<Rigid3> Line(const std::vector<double>& xs) {
  std::vector<Rigid3> poses;
  for (const double x : xs) {
    poses.push_back({Eigen::Quaterniond::Identity(), {x, 0, 0}});
  }
  return poses;
}

TEST(SelectSourcesTest, SkipsWhatHasHardlyMoved) {
  SourceOptions options;  // 2 cm
  EXPECT_THAT(SelectSources(Line({0, 0.01, 0.019, 0.021, 0.03, 0.0411, 0}), options),
              ElementsAre(0, 3, 5, 6));
  EXPECT_THAT(SelectSources({}, options), SizeIs(0));
}

TEST(SelectSourcesTest, GivesAPlaceViewsOnce) {
  SourceOptions options;
  options.every_m = 0.5;
  options.against = SourceSpacing::kAll;
  std::vector<Rigid3> poses = Line({0, 0.4, 0.6, 1.2, 0.5, 0.1});
  EXPECT_THAT(SelectSources(poses, options), ElementsAre(0, 2, 3));
  // The way back looks the other way.
  options.every_deg = 30;
  poses[5].q = FromYaw(M_PI);
  EXPECT_THAT(SelectSources(poses, options), ElementsAre(0, 2, 3, 5));
}

TEST(SelectSourcesTest, OptionsNameWhatIsWrong) {
  SourceOptions sources;
  sources.every_m = -1;
  EXPECT_THAT(sources.Validate(), ElementsAre(HasSubstr("every_m: -1")));
  SamplingOptions sampling;
  sampling.min_radius_m = 1;
  sampling.spacing_min_m = 2;
  sampling.rotation_deg = NAN;
  EXPECT_THAT(sampling.Validate(),
              ElementsAre(HasSubstr("min_radius_m: 1"),
                          HasSubstr("spacing_min_m: 2"),
                          HasSubstr("rotation_deg: nan")));
}

}  // namespace
}  // namespace deja_view
