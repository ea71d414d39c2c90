#include <string>

#include "camera_files_fixture.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const std::string kFusion =
    "%YAML:1.0\n\nimu: 1\nnum_of_cam: 2\nimu_topic: \"/imu\"\n"
    "image0_topic: \"/left\"\nimage1_topic: \"/right\"\n"
    "cam0_calib: \"left.yaml\"\ncam1_calib: \"right.yaml\"\n"
    "image_width: 640\nimage_height: 480\nestimate_extrinsic: 0\n" +
    OpenCvMatrix("body_T_cam0") +
    "pose_graph_save_path: \"/tmp/graph/\"\n"
    "load_previous_pose_graph: 1\n";

constexpr const char* kFusionCamera = R"(%YAML:1.0
---
model_type: PINHOLE
camera_name: camera
image_width: 640
image_height: 480
distortion_parameters:
   k1: 0.1
   k2: 0.01
   p1: 0.001
   p2: 0.002
projection_parameters:
   fx: 400
   fy: 410
   cx: 320
   cy: 240
)";

TEST_F(CameraFilesTest, ReadsVinsFusion) {
  Write("left.yaml", kFusionCamera);
  const VinsConfig config = Read(kFusion);
  ExpectRadTan(config);
  ExpectExtrinsic(config);
  EXPECT_EQ(config.image_topic, "/left");
  EXPECT_EQ(config.imu_topic, "/imu");
  EXPECT_EQ(config.pose_graph_save_path, "/tmp/graph/");
  EXPECT_TRUE(config.load_previous_pose_graph);

  Write("left.yaml",
        "model_type: KANNALA_BRANDT\nimage_width: 640\nimage_height: 480\nprojection_parameters:\n"
        "  {k2: 0.1, k3: 0.01, k4: 0.001, k5: 0.0001, mu: 400, mv: 410, u0: 320, v0: 240}\n");
  ExpectEquidistant(Read(kFusion));
}

TEST_F(CameraFilesTest, NamesWhatIsWrongWithVinsFusion) {
  EXPECT_THAT(Error(kFusion),
              AllOf(HasSubstr("'cam0_calib': expected a file with the first camera's model"),
                    HasSubstr("found 'left.yaml'")));
  Write("left.yaml", kFusionCamera);
  ExpectErrors(
      kFusion,
      {{"cam0_calib: \"left.yaml\"\n", "", "key 'cam0_calib' is missing"},
       {"body_T_cam0",
        "body_T_cam9",
        "key 'body_T_cam0' is missing: expected an opencv-matrix of 4 x 4"},
       {"image0_topic", "image_topic", "key 'image0_topic' is missing"},
       {"[0, 0, 1,", "[0, 0.1, 1,", "key 'body_T_cam0': expected a rotation matrix"},
       {"0.3,", ".nan,", "finite numbers, found '.nan'"},
       {"0, 0, 0, 1]", "0, 0, 1, 1]", "expected a last row of 0, 0, 0, 1, found 0, 0, 1, 1"},
       {"rows: 4", "rows: 3", "4 x 4"}});
  Write("left.yaml", Replaced(kFusionCamera, "PINHOLE", "SCARAMUZZA"));
  EXPECT_THAT(Error(kFusion, "left.yaml"),
              HasSubstr("expected PINHOLE, KANNALA_BRANDT or MEI, found 'SCARAMUZZA'"));
}

}  // namespace
}  // namespace deja_view
