#include "deja_view/nerf/depth_metrics.hpp"

#include <gmock/gmock.h>

namespace deja_view::nerf {
namespace {

using ::testing::ElementsAre;
using ::testing::FloatEq;

TEST(RelativeDepthErrors, SkipsWhatIsUnknownAndCountsHoles) {
  const cv::Mat real = (cv::Mat_<float>(1, 4) << 2, 0, 4, 1);
  const cv::Mat rendered = (cv::Mat_<float>(1, 4) << 3, 5, 4, 0);
  EXPECT_THAT(RelativeDepthErrors(real, rendered), ElementsAre(FloatEq(0.5F), 0.0F, 1.0F));
}

TEST(RelativeDepthErrors, TakesTheNearestPixelOfALargerMap) {
  const cv::Mat real = (cv::Mat_<float>(2, 4) << 1, 1, 1, 1, 1, 2, 1, 8);
  const cv::Mat rendered = (cv::Mat_<float>(1, 2) << 2, 4);
  EXPECT_THAT(RelativeDepthErrors(real, rendered), ElementsAre(0.0F, FloatEq(0.5F)));
}

}  // namespace
}  // namespace deja_view::nerf
