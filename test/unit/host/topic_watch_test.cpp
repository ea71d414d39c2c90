#include "deja_view/host/topic_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class TopicWatchTest : public testing::Test {
 protected:
  TopicWatch watch_{{{"/image", "sensor_msgs/Image", true}, {"/keyframe", "nav_msgs/Odometry"}},
                    100.0};
};

TEST_F(TopicWatchTest, WarnsOnceAfterThreeSecondsAndAgainEveryTen) {
  EXPECT_THAT(watch_.Warn(102.9, {}), IsEmpty());
  EXPECT_THAT(watch_.Silent(102.9), IsEmpty());
  EXPECT_THAT(watch_.Warn(103, {}),
              ElementsAre("no message on /image for 3 s: nobody publishes it",
                          "no message on /keyframe for 3 s: nobody publishes it"));
  EXPECT_THAT(watch_.Warn(112.9, {}), IsEmpty());
  EXPECT_THAT(watch_.Silent(112.9), ElementsAre("/image", "/keyframe"));
  EXPECT_THAT(watch_.Warn(113, {}),
              ElementsAre("no message on /image for 13 s: nobody publishes it",
                          "no message on /keyframe for 13 s: nobody publishes it"));
}

TEST_F(TopicWatchTest, SaysWhatIsPublishedInstead) {
  EXPECT_THAT(
      watch_.Warn(104,
                  {{"/image", "sensor_msgs/CompressedImage"}, {"/keyframe", "nav_msgs/Odometry"}}),
      ElementsAre("no message on /image for 4 s: it is published as "
                  "sensor_msgs/CompressedImage, expected sensor_msgs/Image",
                  "no message on /keyframe for 4 s: its publisher is silent"));
}

TEST_F(TopicWatchTest, KeyframesMayPauseButAStreamMayNot) {
  watch_.Hear("/image", 103);
  watch_.Hear("/keyframe", 103);
  watch_.Hear("/other", 103);
  EXPECT_THAT(watch_.Silent(105), IsEmpty());
  EXPECT_THAT(watch_.Warn(106, {}),
              ElementsAre("no message on /image for 3 s: nobody publishes it"));
}

TEST_F(TopicWatchTest, ASecondSilenceIsWarnedOfAtItsOwnTime) {
  watch_.Hear("/keyframe", 100);
  EXPECT_THAT(watch_.Warn(103, {}), testing::SizeIs(1));
  watch_.Hear("/image", 104);
  EXPECT_THAT(watch_.Warn(106, {}), IsEmpty());
  EXPECT_THAT(watch_.Warn(107, {}), testing::SizeIs(1));
}

}  // namespace
}  // namespace deja_view
