#include "deja_view/camera/mei_camera.hpp"

#include <cstdlib>
#include <string>

#include "camera_files_fixture.hpp"

namespace deja_view {
namespace {

using ::testing::HasSubstr;

constexpr const char* kPinhole = R"(%YAML:1.0
#common parameters
imu_topic: "/imu0"
image_topic: "/cam0/image_raw"
output_path: "/tmp/output/"
model_type: PINHOLE
camera_name: camera
image_width: 752
image_height: 480
distortion_parameters:
   k1: -2.917e-01
   k2: 8.228e-02
   p1: 5.333e-05
   p2: -1.578e-04
projection_parameters:
   fx: 4.616e+02
   fy: 4.603e+02
   cx: 3.630e+02
   cy: 2.481e+02
estimate_extrinsic: 0   # 0  Have an accurate extrinsic parameters.
extrinsicRotation: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [0.0148655429818, -0.999880929698, 0.00414029679422,
           0.999557249008, 0.0149672133247, 0.025715529948,
           -0.0257744366974, 0.00375618835797, 0.999660727178]
extrinsicTranslation: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [-0.0216401454975,-0.064676986768, 0.00981073058949]
max_cnt: 150
loop_closure: 1
fast_relocalization: 1
load_previous_pose_graph: 0
pose_graph_save_path: "/tmp/output/pose_graph/"
)";

using VinsConfigTest = CameraFilesTest;

TEST_F(VinsConfigTest, ReadsAPinhole) {
  const VinsConfig config = Read(kPinhole);
  const auto* camera = dynamic_cast<const PinholeCamera*>(config.camera.get());
  ASSERT_NE(camera, nullptr);
  EXPECT_EQ(camera->width(), 752);
  EXPECT_EQ(camera->height(), 480);
  EXPECT_EQ(camera->parameters().fx, 461.6);
  EXPECT_EQ(camera->parameters().p2, -1.578e-4);
  EXPECT_NEAR(config.T_B_C.R()(1, 0), 0.999557249008, 1e-9);
  EXPECT_NEAR(config.T_B_C.q.norm(), 1.0, 1e-15);
  EXPECT_EQ(config.T_B_C.t.y(), -0.064676986768);
  EXPECT_EQ(config.image_topic, "/cam0/image_raw");
  EXPECT_EQ(config.imu_topic, "/imu0");
  EXPECT_TRUE(config.loop_closure);
  EXPECT_TRUE(config.fast_relocalization);
  EXPECT_FALSE(config.load_previous_pose_graph);
  EXPECT_EQ(config.pose_graph_save_path, "/tmp/output/pose_graph/");
}

TEST_F(VinsConfigTest, ReadsTheSharedFile) {
  const char* data = std::getenv("DEJA_VIEW_DATA");
  if (data == nullptr || !std::filesystem::exists(std::filesystem::path(data) / "euroc.yaml")) {
    GTEST_SKIP() << "set DEJA_VIEW_DATA to the data directory";
  }
  EXPECT_EQ(ReadVinsConfig(std::filesystem::path(data) / "euroc.yaml").camera->width(), 752);
}

TEST_F(VinsConfigTest, ReadsAFisheyeAndAnOmnidirectionalCamera) {
  std::string text = kPinhole;
  text.replace(text.find("PINHOLE"), 7, "KANNALA_BRANDT");
  text.replace(text.find("   fx:"),
               6,
               "   k2: 0.01\n   k3: 0.02\n   k4: 0.03\n   k5: 0.04\n"
               "   mu: 400\n   mv: 401\n   u0: 370\n   v0: 240\n   fx:");
  const VinsConfig fisheye = Read(text);
  const auto* kannala = dynamic_cast<const KannalaBrandtCamera*>(fisheye.camera.get());
  ASSERT_NE(kannala, nullptr);
  EXPECT_EQ(kannala->parameters().k5, 0.04);
  EXPECT_EQ(kannala->parameters().v0, 240);

  text = kPinhole;
  text.replace(text.find("PINHOLE"), 7, "MEI");
  text.replace(text.find("distortion_"), 11, "mirror_parameters:\n   xi: 1.9\ndistortion_");
  text.replace(
      text.find("   fx:"), 6, "   gamma1: 800\n   gamma2: 801\n   u0: 370\n   v0: 240\n   fx:");
  const VinsConfig omnidirectional = Read(text);
  const auto* mei = dynamic_cast<const MeiCamera*>(omnidirectional.camera.get());
  ASSERT_NE(mei, nullptr);
  EXPECT_EQ(mei->parameters().xi, 1.9);
  EXPECT_EQ(mei->parameters().gamma2, 801);
  EXPECT_EQ(mei->parameters().k1, -0.2917);
  text.replace(text.find("xi: 1.9"), 7, "xi: -1 ");
  EXPECT_THROW(Read(text), InputError);
}

TEST_F(VinsConfigTest, NamesWhatIsWrong) {
  ExpectErrors(
      kPinhole,
      {{"   fx: 4.616e+02\n", "", "key 'projection_parameters.fx' is missing"},
       {"fx: 4.616e+02",
        "fx: wide",
        ":16: key 'projection_parameters.fx': expected a number, found 'wide'"},
       {"fx: 4.616e+02", "fx: .nan", "expected a finite number"},
       {"fy: 4.603e+02", "fy: -1", "expected a number above 0"},
       {"image_width: 752", "image_width: 0", "'image_width'"},
       {"PINHOLE", "PINHOLLE", "expected PINHOLE, KANNALA_BRANDT or MEI, found 'PINHOLLE'"},
       {"image_topic: \"/cam0/image_raw\"\n", "", "'image_topic'"},
       {"loop_closure: 1", "loop_closure: 2", "expected 0 or 1"},
       {"0.0148655429818", "0.5", "expected a rotation matrix"},
       {"0.0148655429818", ".inf", "finite numbers"},
       {"0.0148655429818,", "", "opencv-matrix of 3 x 3"},
       {"cols: 1", "cols: 3", "opencv-matrix of 3 x 1"},
       {"distortion_parameters:", "distortion_parameters: 1\nx:", "expected a map of parameters"}});
}

TEST_F(VinsConfigTest, BoundsAndEscapesWhatItEchoes) {
  const std::string error = Error("model_type: \"PIN\\nHOLE" + std::string(3000, 'x') + "\"\n");
  EXPECT_THAT(error, HasSubstr("found 'PIN\\nHOLExxx"));
  EXPECT_LT(error.size(), 300U);
}

TEST_F(VinsConfigTest, RefusesFilesThatAreNoYaml) {
  EXPECT_THROW(ReadVinsConfig("/nonexistent/camera.yaml"), InputError);
  EXPECT_THROW(ReadVinsConfig(std::filesystem::temp_directory_path()), InputError);
  EXPECT_THROW(Read("- 1\n- 2\n"), InputError);
  EXPECT_THROW(Read("a: [1, 2\n"), InputError);
  EXPECT_THROW(Read(""), InputError);
  EXPECT_THROW(Read("text"), InputError);
}

TEST_F(VinsConfigTest, ListsTheLayoutsForAnUnknownOne) {
  for (const char* text : {"", "focal_length: 400\n", "relative_config_imucam: chain.yaml\n"}) {
    EXPECT_THAT(Error(text),
                ::testing::AllOf(HasSubstr("no known camera file"),
                                 HasSubstr("VINS-Mono's (model_type)"),
                                 HasSubstr("VINS-Fusion's (cam0_calib)"),
                                 HasSubstr("camera chain (cam0)"),
                                 HasSubstr("(T_BS)"),
                                 HasSubstr("ORB-SLAM3's settings (Camera.type)")));
  }
  // VINS-Mono's without its model is still VINS-Mono's.
  EXPECT_THAT(Error("extrinsicRotation: 1\n"), HasSubstr("key 'model_type' is missing"));
}

TEST(RequireImageTopic, RequiresATopicOfImages) {
  VinsConfig config;
  EXPECT_EQ(RequireImageTopic(config, "camera.yaml", "/given"), "/given");
  try {
    RequireImageTopic(config, "camera.yaml");
    ADD_FAILURE() << "no error";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("camera.yaml: key 'image_topic' is missing"));
  }
  config.image_topic = "/file";
  EXPECT_EQ(RequireImageTopic(config, "camera.yaml"), "/file");
  EXPECT_EQ(RequireImageTopic(config, "camera.yaml", "/given"), "/given");
}

}  // namespace
}  // namespace deja_view
