#include "deja_view/io/tum.hpp"

#include "deja_view/base/check.hpp"

#include <cstdlib>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace deja_view {
namespace {

using ::testing::HasSubstr;

class TumTest : public ::testing::Test {
 protected:
  ~TumTest() override { std::filesystem::remove(path_); }

  Trajectory Read(const std::string& text) {
    std::ofstream(path_) << text;
    return ReadTum(path_);
  }

  std::string ErrorOf(const std::string& text) {
    try {
      Read(text);
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), HasSubstr(path_.string()));
      return e.what();
    }
    return "no error";
  }

  std::filesystem::path path_ = std::filesystem::temp_directory_path() /
                                ("deja_view_tum_" + std::to_string(::getpid()) + ".txt");
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
  WriteTum(path_, trajectory);
  const Trajectory read = ReadTum(path_);
  EXPECT_EQ(read.stamps_ns, trajectory.stamps_ns);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_LT((read.poses[i].t - trajectory.poses[i].t).norm(), 1e-9);
    EXPECT_LT((read.poses[i].q.coeffs() - trajectory.poses[i].q.coeffs()).norm(), 2e-9);
  }
}

TEST_F(TumTest, NamesTheLineThatIsWrong) {
  EXPECT_THAT(ErrorOf("1 1 2 3 0 0 0 1\n2 1 2 3 0 0 0\n"), HasSubstr(":2: expected 'stamp tx"));
  EXPECT_THAT(ErrorOf("1 1 2 3 0 0 0 1 5\n"), HasSubstr(":1: expected 'stamp tx"));
  EXPECT_THAT(ErrorOf("1 1 2 nan 0 0 0 1\n"), HasSubstr(":1: expected 'stamp tx"));
  EXPECT_THAT(ErrorOf("1 1 2 3x 0 0 0 1\n"), HasSubstr("3x"));
  EXPECT_THAT(ErrorOf("-1 1 2 3 0 0 0 1\n"), HasSubstr(":1: expected 'stamp tx"));
  EXPECT_THAT(ErrorOf("#\n1 1 2 3 0 0 0 2\n"), HasSubstr(":2: expected a unit quaternion"));
  EXPECT_THAT(ErrorOf("2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n"),
              HasSubstr(":2: expected a stamp later"));
  EXPECT_THAT(ErrorOf("2 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n"),
              HasSubstr(":2: expected a stamp later"));
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
