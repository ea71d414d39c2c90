#include "deja_view/base/check.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/lab/report/run.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include "example_run.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace deja_view::report {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kLoopsHeader =
    "stamp_current_ns,stamp_old_ns,tx,ty,tz,qx,qy,qz,qw,score,inliers,virtual,accepted,reason\n";

class ReadRunTest : public ::testing::Test {
 protected:
  ReadRunTest() {
    fs::create_directories(directory_);
    WriteTum(directory_ / "trajectory.txt", ExampleRun().corrected);
    WriteTum(directory_ / "vio.txt", ExampleRun().vio);
    WriteLoops("");
  }
  ~ReadRunTest() override { fs::remove_all(directory_); }

  void WriteLoops(const std::string& rows, const std::string& header = kLoopsHeader) const {
    std::ofstream(directory_ / "loops.csv") << header << rows;
  }
  std::string Error() const {
    try {
      ReadRun(directory_);
    } catch (const InputError& e) {
      return e.what();
    }
    return "no error";
  }

  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("deja_view_read_run_test" + std::to_string(::getpid()));
};

TEST_F(ReadRunTest, ReadsTrajectoriesAndLoops) {
  WriteLoops(
      "1500000000123456789,1400000000000000001,1,-2.5,0.25,0,0,0,1,0.75,33,0,1,accepted\n"
      "1500000000223456789,1400000000000000001,0,0,0,0,0,1,0,0.5,9,1,0,too_few_inliers\n");
  const RunData run = ReadRun(directory_);
  EXPECT_EQ(run.name, directory_.filename().string());
  EXPECT_EQ(run.corrected.size(), 81U);
  EXPECT_EQ(run.vio.stamps_ns, run.corrected.stamps_ns);
  ASSERT_EQ(run.loops.size(), 2U);
  EXPECT_EQ(run.loops[0].stamp_current_ns, 1500000000123456789);
  EXPECT_EQ(run.loops[0].stamp_old_ns, 1400000000000000001);
  EXPECT_EQ(run.loops[0].T_Bold_Bcurrent.t, Eigen::Vector3d(1, -2.5, 0.25));
  EXPECT_EQ(run.loops[0].score, 0.75);
  EXPECT_EQ(run.loops[0].inliers, 33);
  EXPECT_TRUE(run.loops[0].accepted);
  EXPECT_FALSE(run.loops[0].is_virtual);
  EXPECT_EQ(run.loops[1].T_Bold_Bcurrent.q.z(), 1);
  EXPECT_TRUE(run.loops[1].is_virtual);
  EXPECT_FALSE(run.loops[1].accepted);
  EXPECT_EQ(run.loops[1].reason, "too_few_inliers");
}

TEST_F(ReadRunTest, FindsColumnsByName) {
  WriteLoops("accepted,1,2,0,0,0,0,0,0,1,0.5,7,0,1,extra\n",
             "reason,stamp_current_ns,stamp_old_ns,tx,ty,tz,qx,qy,qz,qw,score,inliers,virtual,"
             "accepted,note\n");
  const RunData run = ReadRun(directory_ / "");
  EXPECT_EQ(run.name, directory_.filename().string());
  ASSERT_EQ(run.loops.size(), 1U);
  EXPECT_EQ(run.loops[0].inliers, 7);
}

TEST_F(ReadRunTest, NamesWhatIsWrongInLoops) {
  WriteLoops("1,2,0,0,0,0,0,0,1,0.5,7,0,yes,accepted\n");
  EXPECT_THAT(Error(), HasSubstr("loops.csv:2: accepted is 'yes', expected a number"));
  WriteLoops("1,2,0,0,0,0,0,0,1,0.5,7,0,2,accepted\n");
  EXPECT_THAT(Error(), HasSubstr("accepted is '2', expected 0 or 1"));
  WriteLoops("1,2,nan,0,0,0,0,0,1,0.5,7,0,1,accepted\n");
  EXPECT_THAT(Error(), HasSubstr("tx is 'nan', expected a finite number"));
  WriteLoops("1,2,0,0,0,0,0,0,0.5,0.5,7,0,1,accepted\n");
  EXPECT_THAT(Error(), HasSubstr("expected a quaternion of norm 1"));
  WriteLoops("1,2,0,0\n");
  EXPECT_THAT(Error(), HasSubstr("loops.csv:2: 4 columns, expected 14"));
  WriteLoops("", "stamp_current_ns\n");
  EXPECT_THAT(Error(), HasSubstr("loops.csv:1: expected a column stamp_old_ns"));
  fs::remove(directory_ / "loops.csv");
  EXPECT_THAT(Error(), HasSubstr("loops.csv: can't be opened"));
}

TEST_F(ReadRunTest, RefusesTrajectoriesOfDifferentRuns) {
  Trajectory shorter = ExampleRun().vio;
  shorter.stamps_ns.pop_back();
  shorter.poses.pop_back();
  WriteTum(directory_ / "vio.txt", shorter);
  EXPECT_THAT(Error(), HasSubstr("trajectory.txt (81 poses) and vio.txt (80 poses)"));
}

}  // namespace
}  // namespace deja_view::report
