#include "deja_view/views/view_gate.hpp"

#include "deja_view/camera/pinhole_camera.hpp"

#include "room_renderer.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const auto kCamera =
    std::make_shared<PinholeCamera>(PinholeParameters{160, 120, 100, 100, 79.5, 59.5, 0, 0, 0, 0});

Rigid3 Shift(double x, double y, double z) {
  return {Eigen::Quaterniond::Identity(), {x, y, z}};
}

TEST(ViewGateTest, StaysBeforeTheWalls) {
  const ViewGate gate({}, kCamera, {});
  const RoomRenderer room;
  // The wall on the right is 4 m away, that below 3 m, that ahead 2 m.
  EXPECT_EQ(gate.Judge(room, {}, Shift(3, 0, 0)), GateVerdict::kAccepted);
  EXPECT_EQ(gate.Judge(room, {}, Shift(3.95, 0, 0)), GateVerdict::kNotFree);
  EXPECT_EQ(gate.Judge(room, {}, Shift(0, 0, 1.5)), GateVerdict::kAccepted);
  EXPECT_EQ(gate.Judge(room, {}, Shift(0, 0, 1.9)), GateVerdict::kNotFree);
  EXPECT_EQ(gate.Judge(room, {}, Shift(0, 0, -2.5)), GateVerdict::kNotFree);
  EXPECT_EQ(gate.Judge(room, {}, Shift(0, 0, 0)), GateVerdict::kAccepted);
}

TEST(ViewGateTest, FreeIsWhereTheDroneFlew) {
  GateOptions options;
  options.flown_m = 0.2;
  const RoomRenderer blind(1.1);  // a sigma is more than the depth
  options.max_depth_sigma = 2;
  const ViewGate gate(options, kCamera, {{0, 0, 0}, {0.8, 0, 0}, {3, 0, 0}});
  EXPECT_EQ(gate.Judge(blind, {}, Shift(0.4, 0.1, 0)), GateVerdict::kAccepted);
  EXPECT_EQ(gate.Judge(blind, {}, Shift(0.4, 0.3, 0)), GateVerdict::kNotFree);
  EXPECT_EQ(gate.Judge(blind, {}, Shift(2.9, 0, 0)), GateVerdict::kAccepted);
  // Between images 2.2 m apart nobody knows.
  EXPECT_EQ(gate.Judge(blind, {}, Shift(2, 0, 0)), GateVerdict::kNotFree);
}

TEST(ViewGateTest, AsksForACertainRender) {
  GateOptions options;
  options.free_space = false;
  const ViewGate gate(options, kCamera, {});
  EXPECT_EQ(gate.Judge(RoomRenderer(0.09), {}, Shift(1, 0, 0)), GateVerdict::kAccepted);
  EXPECT_EQ(gate.Judge(RoomRenderer(0.11), {}, Shift(1, 0, 0)), GateVerdict::kUncertain);
  options.min_certain_share = 0;
  const ViewGate open(options, kCamera, {});
  EXPECT_EQ(open.Judge(RoomRenderer(0.11), {}, Shift(1, 0, 0)), GateVerdict::kAccepted);
}

TEST(ViewGateTest, CountsCertainPixels) {
  RenderedView view = RoomRenderer(0.05).Render(*kCamera, {}, {});
  const GateOptions options;
  EXPECT_EQ(CertainShare(view, options), 1.0);
  view.opacity(cv::Rect(0, 0, 160, 30)).setTo(0.5);
  view.depth(cv::Rect(0, 90, 160, 30)).setTo(0);
  EXPECT_EQ(CertainShare(view, options), 0.5);
  const cv::Mat certainty = CertaintyOf(view, options);
  // 255 / (1 + (0.05 / 0.1)^2), half of that, and nothing.
  EXPECT_EQ(certainty.at<std::uint8_t>(60, 80), 204);
  EXPECT_EQ(certainty.at<std::uint8_t>(10, 80), 102);
  EXPECT_EQ(certainty.at<std::uint8_t>(100, 80), 0);
}

TEST(ViewGateTest, OptionsNameWhatIsWrong) {
  GateOptions options;
  options.min_opacity = 2;
  options.scale = 0;
  EXPECT_THAT(options.Validate(), ElementsAre(HasSubstr("min_opacity: 2"), HasSubstr("scale: 0")));
}

}  // namespace
}  // namespace deja_view
