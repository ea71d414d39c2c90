#include "deja_view/base/check.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include "image_files.hpp"
#include <gmock/gmock.h>

namespace deja_view::nerf {
namespace {

using ::testing::AllOf;
using ::testing::Not;

class TrajectoryImagesTest : public ImageFilesTest {
 protected:
  TrajectoryImagesTest() {
    trajectory_.stamps_ns = {1'000'000'000, 1'050'000'000, 1'100'000'000};
    for (int i = 0; i < 3; ++i) {
      trajectory_.poses.push_back({Eigen::Quaterniond::Identity(), Eigen::Vector3d(i, 0, 0)});
    }
  }
  std::vector<PosedImage> Read(bool skip_missing = false) const {
    const Rigid3 T_B_C{Eigen::Quaterniond::Identity(), {0, 0, 3}};
    return ReadTrajectoryImages(directory_, SmallCamera(), T_B_C, trajectory_, skip_missing);
  }
  std::string Error(bool skip_missing = false) const {
    return MessageOf<InputError>([&] { Read(skip_missing); });
  }

  Trajectory trajectory_;
};

TEST_F(TrajectoryImagesTest, FollowTheTrajectory) {
  WriteImage("1025000000.png");
  WriteImage("1.000.png");
  WriteImage("1025000000.depth.png");
  Write("notes.txt", "no image");
  const std::vector<PosedImage> images = Read();
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[0].stamp_ns, 1'000'000'000);
  EXPECT_LT((images[1].T_N_C.t - Eigen::Vector3d(0.5, 0, 3)).norm(), 1e-12);
}

TEST_F(TrajectoryImagesTest, AreFoundInEurocsFolders) {
  WriteImage("mav0/cam0/data/1000000000.png");
  EXPECT_EQ(Read().size(), 1U);
}

TEST_F(TrajectoryImagesTest, ErrorsNameTheFile) {
  EXPECT_THAT(Error(), Says("holds no image"));
  WriteImage("1000000000.png");
  WriteImage("2000000000.png");
  EXPECT_THAT(Error(), Says("1 of 2 images", "(2000000000)"));
  EXPECT_EQ(Read(true).size(), 1U);
  for (int i = 0; i < 4; ++i) {
    WriteImage(std::to_string(3'000'000'000 + i) + ".png");
  }
  EXPECT_THAT(Error(), AllOf(Says("5 of 6"), Says("..."), Not(Says("3000000003"))));
  WriteImage("frame7.png");
  EXPECT_THAT(Error(), Says("frame7.png"));
}

TEST_F(TrajectoryImagesTest, SkippingAllIsAnError) {
  WriteImage("2000000000.png");
  EXPECT_THAT(Error(true), Says("1 of 1 images"));
}

}  // namespace
}  // namespace deja_view::nerf
