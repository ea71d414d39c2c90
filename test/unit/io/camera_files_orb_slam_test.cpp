#include <string>

#include "camera_files_fixture.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using ::testing::HasSubstr;

const std::string kOrbSlam = R"(%YAML:1.0
File.version: "1.0"
Camera.type: "PinHole"
Camera1.fx: 400.0
Camera1.fy: 410.0
Camera1.cx: 320.0
Camera1.cy: 240.0
Camera1.k1: 0.1
Camera1.k2: 0.01
Camera1.p1: 0.001
Camera1.p2: 0.002
Camera.width: 640
Camera.height: 480
Camera.newWidth: 320
Camera.newHeight: 240
Camera.fps: 20
)" + OpenCvMatrix("IMU.T_b_c1") +
                             "IMU.Frequency: 200.0\n";

TEST_F(CameraFilesTest, ReadsOrbSlam) {
  const VinsConfig config = Read(kOrbSlam);
  ExpectRadTan(config);
  ExpectExtrinsic(config);
  EXPECT_EQ(config.image_topic, "");

  const std::string fisheye = Replaced(Replaced(kOrbSlam, "PinHole", "KannalaBrandt8"),
                                       "Camera1.p1: 0.001\nCamera1.p2: 0.002\n",
                                       "Camera1.k3: 0.001\nCamera1.k4: 0.0001\n");
  ExpectEquidistant(Read(fisheye));

  // Before version 1.0.
  const std::string old =
      Replaced(Replaced(Replaced(kOrbSlam, "Camera1.", "Camera."), "IMU.T_b_c1", "Tbc"),
               "File.version: \"1.0\"\n",
               "");
  ExpectRadTan(Read(old));
  ExpectExtrinsic(Read(old));
  ExpectRadTan(Read(old + "Camera.k3: 0.0\n"));
}

TEST_F(CameraFilesTest, ReadsOrbSlamWithoutDistortion) {
  const std::string four =
      "Camera1.k1: 0.1\nCamera1.k2: 0.01\nCamera1.p1: 0.001\nCamera1.p2: 0.002\n";
  for (const std::string& text :
       {Replaced(kOrbSlam, four, ""), Replaced(kOrbSlam, "PinHole", "Rectified")}) {
    const auto pixel = Read(text).camera->Project({0.5, 0.25, 1.0});
    ASSERT_TRUE(pixel.has_value());
    EXPECT_NEAR(pixel->x(), 520, 1e-9);
    EXPECT_NEAR(pixel->y(), 342.5, 1e-9);
  }
}

TEST_F(CameraFilesTest, NamesWhatIsWrongWithOrbSlam) {
  ExpectErrors(kOrbSlam,
               {{"PinHole",
                 "Omni",
                 "'Camera.type': expected PinHole, KannalaBrandt8 or Rectified, found 'Omni'"},
                {"Camera.type: \"PinHole\"\n", "", "'Camera.type' is missing"},
                {"Camera1.fx: 400.0\n", "", "key 'Camera1.fx' is missing"},
                {"Camera1.fx: 400.0", "Camera1.fx: 0", "a number above 0"},
                {"Camera1.cx: 320.0", "Camera1.cx: .nan", "a finite number"},
                {"Camera1.p2: 0.002\n", "", "key 'Camera1.p2' is missing"},
                {"PinHole", "KannalaBrandt8", "key 'Camera1.k3' is missing"},
                {"Camera1.p2", "Camera1.k3: 0.5\nCamera1.p2", "key 'Camera1.k3': expected 0"},
                {"Camera.width: 640", "Camera.width: 0", "'Camera.width'"},
                {"Camera.height: 480", "Camera.height: tall", "'Camera.height'"},
                {"IMU.T_b_c1", "IMU.T_c1_b", "key 'IMU.T_b_c1' is missing"},
                {"0.1,  -1", "0.1,  1", "'IMU.T_b_c1': expected a rotation matrix"}});
}

}  // namespace
}  // namespace deja_view
