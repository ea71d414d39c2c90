#include "deja_view/base/check.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include "image_files.hpp"
#include <gmock/gmock.h>

namespace deja_view::nerf {
namespace {

class ColmapImagesTest : public ImageFilesTest {
 protected:
  ColmapImagesTest() {
    Write("sparse/0/cameras.txt", "1 PINHOLE 16 12 10 10 8 6\n");
    // The camera of a.png is at (0, 0, -2), that of b.png at (1, 0, 0).
    Write("sparse/0/images.txt",
          "1 1 0 0 0 0 0 2 1 a.png\n8 6 1 9 6 2 10 6 3\n2 1 0 0 0 -1 0 0 1 b.png\n8 6 1\n");
    Write("sparse/0/points3D.txt",
          "1 0 0 1 0 0 0 0.5 1 0 2 0 3 0\n"
          "2 0.1 0 0 0 0 0 5.0 1 1 2 0 3 0\n"  // a large error
          "3 0.2 0 0 0 0 0 0.5 1 2 2 0\n");    // seen twice
    WriteImage("images/a.png");
    WriteImage("images/b.png");
  }
  std::string Error() const {
    return MessageOf<InputError>([&] { ReadColmapImages(directory_, {}); });
  }
};

TEST_F(ColmapImagesTest, ReadsPosesAndGoodPoints) {
  const std::vector<PosedImage> images = ReadColmapImages(directory_, {});
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[0].path, directory_ / "images/a.png");
  EXPECT_LT((images[0].T_N_C.t - Eigen::Vector3d(0, 0, -2)).norm(), 1e-12);
  ASSERT_EQ(images[0].points.size(), 1U);
  EXPECT_EQ(images[0].points[0].u, 7.5F);
  EXPECT_EQ(images[0].points[0].v, 5.5F);
  EXPECT_FLOAT_EQ(images[0].points[0].range, 3);
  // Where the point projects to.
  EXPECT_LT((*images[0].camera->Project({0, 0, 3}) - Eigen::Vector2d(7.5, 5.5)).norm(), 1e-12);
  EXPECT_FLOAT_EQ(images[1].points.at(0).range, std::sqrt(2.0F));
}

TEST_F(ColmapImagesTest, MissingFilesAndPosesAreErrors) {
  WriteImage("images/c.png");
  EXPECT_THAT(Error(), Says("1 of 3 images have no pose", "c.png"));
  EXPECT_EQ(ReadColmapImages(directory_, {}, true).size(), 2U);
  std::filesystem::remove(directory_ / "images/a.png");
  EXPECT_THAT(Error(), Says("1 of 2 poses have no image file", "a.png"));
  EXPECT_EQ(ReadColmapImages(directory_, {}, true).size(), 1U);
  std::filesystem::remove_all(directory_ / "images");
  EXPECT_THAT(Error(), Says("no folder 'images'"));
}

}  // namespace
}  // namespace deja_view::nerf
