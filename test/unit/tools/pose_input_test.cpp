#include "common/pose_input.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>

#include "temporary_directory.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using ::testing::HasSubstr;

class PoseInputTest : public TemporaryDirectoryTest {
 protected:
  std::string Poses() const { return Write("poses.txt", "1.5 1 2 3 0 0 0 1\n2.5 4 5 6 0 0 0 1\n"); }
};

TEST_F(PoseInputTest, ReadsAFile) {
  const PoseSource body = ReadPoses(Poses(), false);
  ASSERT_EQ(body.trajectory.size(), 2U);
  EXPECT_EQ(body.trajectory.stamps_ns[0], 1'500'000'000);
  EXPECT_EQ(body.trajectory.poses[1].t, Eigen::Vector3d(4, 5, 6));
  EXPECT_FALSE(body.is_of_camera);
  EXPECT_TRUE(body.has_scale);
  EXPECT_TRUE(ReadPoses(Poses(), true).is_of_camera);
}

TEST_F(PoseInputTest, TakesAFileBeforeATopic) {
  EXPECT_EQ(ReadFlightPoses(Poses(), directory_ / "flight.bag", false).trajectory.size(), 2U);
}

TEST_F(PoseInputTest, SaysWhatItExpects) {
  EXPECT_THAT(MessageOf<InputError>([&] { ReadFlightPoses("missing.txt", "", false); }),
              AllOf(HasSubstr("missing.txt: no such file or topic"), HasSubstr("BAG:/topic")));
  EXPECT_THAT(MessageOf<InputError>(
                  [&] { ReadPoses((directory_ / "missing.bag:/odometry").string(), false); }),
              HasSubstr("missing.bag"));
}

TEST(PoseInputJson, TellsDegrees) {
  RobustAlignment alignment;
  alignment.pairs = 7;
  alignment.rotation_rad = M_PI / 6;
  alignment.A_B.scale = 2;
  const auto json = ToJson(alignment);
  EXPECT_EQ(json["pairs"], 7);
  EXPECT_NEAR(json["rotation_deg"].get<double>(), 30, 1e-12);
  EXPECT_EQ(json["scale"], 2);
}

}  // namespace
}  // namespace deja_view
