#include "deja_view/io/tum.hpp"

#include "deja_view/base/check.hpp"

#include <cstdlib>
#include <fstream>

#include "temporary_directory.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

class TumTest : public TemporaryDirectoryTest {
 protected:
  Trajectory Read(const std::string& text) const { return ReadTum(Write("poses.txt", text)); }

  std::string ErrorOf(const std::string& text) const {
    return MessageOf<InputError>([&] { Read(text); });
  }
};

TEST_F(TumTest, ReadsPosesCommentsAndBlankLines) {
  const Trajectory trajectory =
      Read("# a comment\n\n1.5 1 2 3 0 0 0 1\r\n  # another\n2.000000001\t4 5 6 0 0 1.0000001 0");
  ASSERT_EQ(trajectory.size(), 2U);
  EXPECT_EQ(trajectory.stamps_ns[1], 2000000001);
  EXPECT_EQ(trajectory.poses[0].t, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(trajectory.poses[1].q.z(), 1.0);
  EXPECT_TRUE(Read("# nothing\n").empty());
}

TEST_F(TumTest, WritesWhatItReads) {
  Trajectory trajectory;
  trajectory.stamps_ns = {1403636625838560104, 1403636625838560105};
  trajectory.poses = {{ExpSo3({0.1, 0.2, -0.3}), {1.25, -2.5, 1e-9}}, {FromYaw(3.0), {0, 0, 100}}};
  const auto path = directory_ / "poses.txt";
  WriteTum(path, trajectory);
  const Trajectory read = ReadTum(path);
  EXPECT_EQ(read.stamps_ns, trajectory.stamps_ns);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_LT((read.poses[i].t - trajectory.poses[i].t).norm(), 1e-9);
    EXPECT_LT((read.poses[i].q.coeffs() - trajectory.poses[i].q.coeffs()).norm(), 2e-9);
  }
}

TEST_F(TumTest, NamesTheLineThatIsWrong) {
  ExpectErrors([&](const std::string& text) { return ErrorOf(text); },
               {{"1 1 2 3 0 0 0 1\n2 1 2 3 0 0 0\n", "poses.txt:2: expected 'stamp tx"},
                {"1 1 2 3 0 0 0 1 5\n", "poses.txt:1: expected 'stamp tx"},
                {"1 1 2 nan 0 0 0 1\n", "poses.txt:1: expected 'stamp tx"},
                {"1 1 2 3x 0 0 0 1\n", "3x"},
                {"-1 1 2 3 0 0 0 1\n", "poses.txt:1: expected 'stamp tx"},
                {"#\n1 1 2 3 0 0 0 2\n", "poses.txt:2: expected a unit quaternion"},
                {"2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", "poses.txt:2: expected a stamp later"},
                {"2 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n", "poses.txt:2: expected a stamp later"}});
  EXPECT_THROW(ReadTum("/nonexistent.txt"), InputError);
  EXPECT_THROW(ReadTum(std::filesystem::temp_directory_path()), InputError);
}

TEST_F(TumTest, ReadsTheSharedGroundTruth) {
  const char* data = std::getenv("DEJA_VIEW_DATA");
  const std::filesystem::path path =
      std::filesystem::path(data == nullptr ? "" : data) / "hall_a" / "groundtruth.txt";
  if (data == nullptr || !std::filesystem::exists(path)) {
    GTEST_SKIP() << "set DEJA_VIEW_DATA to the data directory";
  }
  const Trajectory trajectory = ReadTum(path);
  EXPECT_GT(trajectory.size(), 20000U);
  EXPECT_EQ(trajectory.stamps_ns[0], 1403636625838560104);
}

}  // namespace
}  // namespace deja_view
