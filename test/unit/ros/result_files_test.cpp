#include "deja_view/ros/result_files.hpp"

#include "deja_view/io/tum.hpp"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

TEST(ResultFilesTest, WritesTrajectoriesAndLoops) {
  const fs::path directory =
      fs::path(::testing::TempDir()) / ("deja_view_result_files_test" + std::to_string(::getpid()));
  std::vector<KeyframeInfo> keyframes(3);
  for (int i = 0; i < 3; ++i) {
    keyframes[static_cast<std::size_t>(i)].index = i;
    keyframes[static_cast<std::size_t>(i)].stamp_ns = 1000000001 + i;
    keyframes[static_cast<std::size_t>(i)].T_W_B.t.x() = i;
    keyframes[static_cast<std::size_t>(i)].T_M_B.t.y() = i;
  }
  LoopReport loop;
  loop.stamp_current_ns = 1000000003;
  loop.stamp_old_ns = 1000000001;
  loop.T_Bold_Bcurrent.t = {1, -2, 0.5};
  loop.score = 0.25;
  loop.inliers = 33;
  LoopReport refused = loop;
  refused.reason = RejectReason::kTooFar;
  WriteResultFiles(directory, keyframes, 1, {loop, refused});

  const Trajectory corrected = ReadTum(directory / "trajectory.txt");
  ASSERT_EQ(corrected.stamps_ns, (std::vector<std::int64_t>{1000000002, 1000000003}));
  EXPECT_EQ(corrected.poses[1].t.y(), 2);
  EXPECT_EQ(ReadTum(directory / "vio.txt").poses[1].t.x(), 2);

  std::ifstream stream(directory / "loops.csv");
  std::string line;
  std::getline(stream, line);
  EXPECT_EQ(line,
            "stamp_current_ns,stamp_old_ns,tx,ty,tz,qx,qy,qz,qw,score,inliers,virtual,accepted,"
            "reason");
  std::getline(stream, line);
  EXPECT_EQ(line,
            "1000000003,1000000001,1.000000,-2.000000,0.500000,0.00000000,0.00000000,0.00000000,"
            "1.00000000,0.250000,33,0,1,accepted");
  std::getline(stream, line);
  EXPECT_EQ(line.substr(line.size() - 10), ",0,too_far");
  fs::remove_all(directory);
}

}  // namespace
}  // namespace deja_view
