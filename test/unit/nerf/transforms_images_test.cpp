#include "deja_view/base/check.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include <cmath>

#include "image_files.hpp"
#include <gmock/gmock.h>

namespace deja_view::nerf {
namespace {

constexpr const char* kPose = R"("transform_matrix":[[1,0,0,4],[0,1,0,5],[0,0,1,6],[0,0,0,1]])";

TEST(FromRightUpBack, TurnsTheCamerasAxesOnly) {
  // A NeRF's camera that looks along the world's x, z up: right -y, up z, back -x.
  Eigen::Matrix3d R;
  R << 0, 0, -1, -1, 0, 0, 0, 1, 0;
  const Rigid3 T_N_C = FromRightUpBack({Eigen::Quaterniond(R), {1, 2, 3}});
  EXPECT_LT((T_N_C * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(2, 2, 3)).norm(), 1e-12);  // front
  EXPECT_LT((T_N_C * Eigen::Vector3d(0, 1, 0) - Eigen::Vector3d(1, 2, 2)).norm(), 1e-12);  // down
  EXPECT_LT((T_N_C * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 1, 3)).norm(), 1e-12);  // right
}

class TransformsTest : public ImageFilesTest {
 protected:
  TransformsTest() { WriteImage("images/a.png"); }

  std::vector<PosedImage> Read(const std::string& json, bool skip_missing = false) const {
    return ReadTransforms(Write("transforms.json", json), skip_missing);
  }
  std::string Error(const std::string& json) const {
    return MessageOf<InputError>([&] { Read(json); });
  }
  // A file of one frame.
  static std::string File(const std::string& keys,
                          const std::string& pose = kPose,
                          const std::string& path = "images/a.png") {
    return "{" + keys + R"(,"frames":[{"file_path":")" + path + "\"," + pose + "}]}";
  }
};

TEST_F(TransformsTest, ReadsInstantNgpsFile) {
  const auto images = Read(File(R"("fl_x":10,"fl_y":11,"cx":8,"cy":6.5,"w":16.0,"h":12,"k1":0.1,)"
                                R"("k2":0.2,"p1":0.01,"p2":0.02,"aabb_scale":4)"));
  ASSERT_EQ(images.size(), 1U);
  EXPECT_EQ(images[0].name, "a");
  EXPECT_EQ(images[0].T_N_C.t, Eigen::Vector3d(4, 5, 6));
  EXPECT_LT((images[0].T_N_C * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(4, 5, 5)).norm(), 1e-12);
  const auto& camera = dynamic_cast<const PinholeCamera&>(*images[0].camera);
  EXPECT_EQ(camera.width(), 16);
  EXPECT_EQ(camera.parameters().fy, 11);
  EXPECT_EQ(camera.parameters().cx, 7.5);
  EXPECT_EQ(camera.parameters().cy, 6);
  EXPECT_EQ(camera.parameters().p2, 0.02);
}

TEST_F(TransformsTest, ReadsBlendersFile) {
  // Without sizes or extensions.
  const auto images = Read(File(R"("camera_angle_x":1.2)", kPose, "./images/a"));
  const auto& camera = dynamic_cast<const PinholeCamera&>(*images.at(0).camera);
  EXPECT_EQ(camera.width(), 16);
  EXPECT_NEAR(camera.parameters().fx, 8 / std::tan(0.6), 1e-12);
  EXPECT_EQ(camera.parameters().fy, camera.parameters().fx);
  EXPECT_EQ(camera.parameters().cx, 7.5);
}

TEST_F(TransformsTest, ReadsNerfstudiosFrames) {
  WriteImage("images/b.png");
  const std::string frame = std::string(R"(,"w":16,"h":12,"fl_y":10,"cx":8,"cy":6,)") + kPose;
  const auto images =
      Read(R"({"camera_model":"OPENCV_FISHEYE","k1":0.1,"k2":0.2,"k3":0.3,"k4":0.4,)"
           R"("depth_unit_scale_factor":0.01,"frames":[)"
           R"({"file_path":"images/b.png","fl_x":20,"depth_file_path":"depth/b.png")" +
           frame + R"(},{"file_path":"images/a.png","fl_x":10)" + frame + "}]}");
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[0].name, "a");
  EXPECT_TRUE(images[0].depth.path.empty());
  EXPECT_EQ(images[1].depth.path, directory_ / "depth/b.png");
  EXPECT_EQ(images[1].depth.unit_m, 0.01);
  EXPECT_EQ(images[0].camera->ModelType(), "KANNALA_BRANDT");
  EXPECT_NEAR(images[0].camera->FocalLength(), 10, 1e-9);
  EXPECT_NEAR(images[1].camera->FocalLength(), 15, 1e-9);
}

TEST_F(TransformsTest, MissingImagesAreErrors) {
  const std::string two = std::string(R"({"fl_x":10,"w":16,"h":12,"frames":[)") +
                          R"({"file_path":"images/a.png",)" + kPose +
                          R"(},{"file_path":"images/none.png",)" + kPose + "}]}";
  EXPECT_THAT(Error(two), Says("1 of 2 frames", "images/none.png"));
  EXPECT_EQ(Read(two, true).size(), 1U);
}

TEST_F(TransformsTest, DegeneratePosesNameTheirFrame) {
  const std::string keys = R"("fl_x":10,"w":16,"h":12)";
  for (const char* pose : {
           R"("transform_matrix":[[1,0,0,4],[0,1.1,0,5],[0,0,1,6],[0,0,0,1]])",
           R"("transform_matrix":[[1,0,0,4],[0,1,0,5],[0,0,-1,6],[0,0,0,1]])",
           R"("transform_matrix":[[1,0,0,null],[0,1,0,5],[0,0,1,6],[0,0,0,1]])",
           R"("transform_matrix":[[1,0,0],[0,1,0],[0,0,1],[0,0,0]])",
           R"("transform_matrix":[[1,0,0,4],[0,1,0,5]])",
           R"("transform_matrix":[[1,0,0,4],[0,1,0,5],[0,0,1,6],[0,0,1,1]])",
           R"("transform":0)",
       }) {
    EXPECT_THAT(Error(File(keys, pose)), Says("transforms.json: frame 0", "transform_matrix"))
        << pose;
  }
}

TEST_F(TransformsTest, BadKeysAreNamed) {
  EXPECT_THAT(Error("{"), Says("expected JSON"));
  EXPECT_THAT(Error("[]"), Says("expected JSON"));
  EXPECT_THAT(Error(R"({"frames":[]})"), Says("'frames'"));
  EXPECT_THAT(Error(R"({"frames":[5]})"), Says("file_path"));
  EXPECT_THAT(Error(File(R"("w":16,"h":12)")), Says("fl_x or camera_angle_x"));
  EXPECT_THAT(Error(File(R"("w":16,"h":12,"fl_x":-3)")), Says("'fl_x'"));
  EXPECT_THAT(Error(File(R"("w":16,"h":12,"fl_x":"ten")")), Says("'fl_x'"));
  EXPECT_THAT(Error(File(R"("w":16.5,"h":12,"fl_x":10)")), Says("'w'"));
  EXPECT_THAT(Error(File(R"("w":16,"h":12,"fl_x":10,"k3":0.1)")), Says("'k3'"));
  EXPECT_THAT(Error(File(R"("w":16,"h":12,"fl_x":10,"camera_model":"EQUIRECTANGULAR")")),
              Says("EQUIRECTANGULAR"));
  EXPECT_THAT(MessageOf<InputError>([&] { ReadTransforms(directory_ / "none.json"); }),
              Says("can't be opened"));
}

}  // namespace
}  // namespace deja_view::nerf
