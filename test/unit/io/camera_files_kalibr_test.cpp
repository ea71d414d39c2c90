#include "deja_view/camera/mei_camera.hpp"

#include <string>

#include "camera_files_fixture.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using ::testing::HasSubstr;

const std::string kChain = std::string(R"(%YAML:1.0 # as OpenVINS wants it
cam0:
  camera_model: pinhole
  intrinsics: [400.0, 410.0, 320.0, 240.0]
  distortion_model: radtan
  distortion_coeffs: [0.1, 0.01, 0.001, 0.002]
  resolution: [640, 480]
  rostopic: /left/image
  timeshift_cam_imu: 0.01
  T_cam_imu:
)") + kInverseRows + R"(cam1:
  camera_model: ds
  T_cn_cnm1: 1
)";

const std::string kAsl = std::string(R"(%YAML:1.0
sensor_type: camera
comment: made up
T_BS:
  cols: 4
  rows: 4
  )") + kData + R"(rate_hz: 20
resolution: [640, 480]
camera_model: pinhole
intrinsics: [400.0, 410.0, 320.0, 240.0] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [0.1, 0.01, 0.001, 0.002]
)";

TEST_F(CameraFilesTest, ReadsKalibrsChain) {
  const VinsConfig config = Read(kChain);
  ExpectRadTan(config);
  ExpectExtrinsic(config);
  EXPECT_EQ(config.image_topic, "/left/image");
  EXPECT_EQ(config.imu_topic, "");
  EXPECT_TRUE(config.loop_closure);

  const std::string fisheye = Replaced(Replaced(kChain, "radtan", "equidistant"),
                                       "[0.1, 0.01, 0.001, 0.002]",
                                       "[0.1, 0.01, 0.001, 0.0001]");
  ExpectEquidistant(Read(fisheye));
}

TEST_F(CameraFilesTest, ReadsAChainWithoutDistortion) {
  const std::string text =
      Replaced(Replaced(kChain, "radtan", "none"), "[0.1, 0.01, 0.001, 0.002]", "[]");
  const auto pixel = Read(text).camera->Project({0.5, 0.25, 1.0});
  ASSERT_TRUE(pixel.has_value());
  EXPECT_NEAR(pixel->x(), 520, 1e-9);
  EXPECT_NEAR(pixel->y(), 342.5, 1e-9);
}

// (3, 0, 4) m is 5 m away: x = 3 / (4 + 0.8 * 5) = 0.375, s = 0.140625,
// x (1 + 0.1 s + 0.01 s^2) + 0.002 * 3 s = 0.375 * 1.01426025390625 + 0.00084375,
// y = 0.001 s.
TEST_F(CameraFilesTest, ReadsAnOmnidirectionalChain) {
  const std::string text = Replaced(Replaced(kChain, "camera_model: pinhole", "camera_model: omni"),
                                    "[400.0, 410.0, 320.0, 240.0]",
                                    "[0.8, 400.0, 410.0, 320.0, 240.0]");
  const VinsConfig config = Read(text);
  ASSERT_NE(dynamic_cast<const MeiCamera*>(config.camera.get()), nullptr);
  const auto pixel = config.camera->Project({3.0, 0.0, 4.0});
  ASSERT_TRUE(pixel.has_value());
  EXPECT_NEAR(pixel->x(), 400 * 0.3811913452148438 + 320, 1e-9);
  EXPECT_NEAR(pixel->y(), 410 * 0.000140625 + 240, 1e-9);
}

TEST_F(CameraFilesTest, TakesOpenVinsCameraToImuAsItIs) {
  const std::string text =
      Replaced(Replaced(kChain, "T_cam_imu", "T_imu_cam"), kInverseRows, kRows);
  ExpectExtrinsic(Read(text));
  // Both directions, as long as they agree.
  const std::string both = std::string("  T_cam_imu:\n") + kInverseRows + "cam1:";
  ExpectExtrinsic(Read(Replaced(text, "cam1:", both)));
  EXPECT_THAT(Error(Replaced(text, "cam1:", Replaced(both, "0.3]", "0.4]"))),
              HasSubstr("key 'cam0.T_cam_imu': expected the inverse of T_imu_cam"));
}

TEST_F(CameraFilesTest, NamesWhatIsWrongWithAChain) {
  ExpectErrors(
      kChain,
      {{"  T_cam_imu:",
        "  T_other:",
        "key 'cam0.T_cam_imu' is missing: expected a list of 4 rows of 4 numbers"},
       {"  - [0, 0, 0, 1]\n", "", "4 rows of 4 numbers"},
       {"[0, -1, 0, 0.2]", "[0, -1, 0]", ":11: key 'cam0.T_cam_imu'"},
       {"[0, -1, 0, 0.2]", "[0, -1.1, 0, 0.2]", "key 'cam0.T_cam_imu': expected a rotation matrix"},
       {"[0, -1, 0, 0.2]", "[0, 1, 0, 0.2]", "determinant -1"},
       {"0.2]", ".nan]", "expected finite numbers"},
       {"camera_model: pinhole",
        "camera_model: ds",
        "key 'cam0.camera_model': expected pinhole or omni, found 'ds'"},
       {"radtan",
        "fov",
        "key 'cam0.distortion_model': expected radtan (radial-tangential), "
        "equidistant or none, found 'fov'"},
       {"0.001, 0.002]",
        "0.001]",
        "'cam0.distortion_coeffs': expected 4 numbers: k1, k2, p1, p2, found 3"},
       {"[400.0, ", "[", "'cam0.intrinsics': expected 4 numbers"},
       {"410.0", "-410.0", "focal lengths above 0"},
       {"410.0", "wide", "found 'wide'"},
       {"410.0", ".inf", "expected finite numbers, found '.inf'"},
       {"[640, 480]",
        "[640, 0]",
        "'cam0.resolution': expected [width, height], each from 1 to 32768"},
       {"[640, 480]", "640", "'cam0.resolution'"},
       {"[640, 480]", "[640.5, 480]", "found '640.5'"}});
  EXPECT_THAT(Error("cam0: 1\n"), HasSubstr("key 'cam0': expected a map of parameters"));

  const std::string omni = Replaced(kChain, "camera_model: pinhole", "camera_model: omni");
  const std::string four = "[400.0, 410.0, 320.0, 240.0]";
  EXPECT_THAT(Error(omni), HasSubstr("expected 5 numbers: xi, fx, fy, cx, cy, found 4"));
  EXPECT_THAT(Error(Replaced(omni, four, "[-1, 400, 410, 320, 240]")), HasSubstr("xi of 0"));
  EXPECT_THAT(Error(Replaced(omni, four, "[1, 400, 0, 320, 240]")), HasSubstr("focal lengths"));
  EXPECT_THAT(Error(Replaced(omni, "radtan", "equidistant")),
              HasSubstr("expected radtan or none beside camera_model omni"));
}

TEST_F(CameraFilesTest, ReadsEurocsSensorAndKimerasCamera) {
  const VinsConfig config = Read(kAsl);
  ExpectRadTan(config);
  ExpectExtrinsic(config);
  EXPECT_EQ(config.image_topic, "");
  EXPECT_EQ(Read(kAsl + "image_topic: /left\nimu_topic: /imu\n").image_topic, "/left");

  const std::string fisheye = Replaced(Replaced(Replaced(kAsl, "radial-tangential", "equidistant"),
                                                "[0.1, 0.01, 0.001, 0.002]",
                                                "[0.1, 0.01, 0.001, 0.0001]"),
                                       "  cols: 4\n  rows: 4\n",
                                       "");
  ExpectEquidistant(Read(fisheye));
  ExpectExtrinsic(Read(fisheye));
}

TEST_F(CameraFilesTest, NamesWhatIsWrongWithASensor) {
  ExpectErrors(
      kAsl,
      {{"camera_model: pinhole",
        "camera_model: omni",
        "key 'camera_model': expected pinhole, found 'omni'"},
       {"camera_model: pinhole\n", "", "key 'camera_model' is missing"},
       {"0.1,  -1", "-1", "key 'T_BS.data': expected 16 numbers, row by row, found 15 values"},
       {"0.1,  -1", "0.1,  -2", "key 'T_BS.data': expected a rotation matrix"},
       {"radial-tangential", "fov", "'distortion_model'"},
       {"distortion_coefficients", "coefficients", "key 'distortion_coefficients' is missing"}});
  EXPECT_THAT(Error("T_BS: [1]\n"), HasSubstr("key 'camera_model' is missing"));
}

}  // namespace
}  // namespace deja_view
