#include "deja_view/fusion/result_files.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/io/tum.hpp"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "temporary_directory.hpp"
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
  keyframes[0].is_place = keyframes[2].is_place = true;
  LoopReport loop;
  loop.stamp_current_ns = 1000000003;
  loop.stamp_old_ns = 1000000001;
  loop.T_Bold_Bcurrent.t = {1, -2, 0.5};
  loop.score = 0.25;
  loop.inliers = 33;
  LoopReport refused = loop;
  refused.reason = RejectReason::kTooFar;
  LoopMatches matches;
  matches.stamp_current_ns = loop.stamp_current_ns;
  matches.stamp_old_ns = loop.stamp_old_ns;
  matches.is_virtual = true;
  matches.pairs = {{-1, {1.5F, 2}, {3, 4}}, {2, {5, 6}, {7, 8.25F}}};
  LoopRows rows;
  rows.Add(loop);
  rows.Add(refused);
  WriteResultFiles(directory, keyframes, 1, rows, {matches});

  const Trajectory corrected = ReadTum(directory / "trajectory.txt");
  ASSERT_EQ(corrected.stamps_ns, (std::vector<std::int64_t>{1000000002, 1000000003}));
  EXPECT_EQ(corrected.poses[1].t.y(), 2);
  EXPECT_EQ(ReadTum(directory / "vio.txt").poses[1].t.x(), 2);

  EXPECT_EQ(ReadTum(directory / "places.txt").stamps_ns,
            (std::vector<std::int64_t>{1000000001, 1000000003}))
      << "a loaded map's, too";

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

  std::ifstream matched(directory / "matches.csv");
  std::getline(matched, line);
  EXPECT_EQ(line, "stamp_current_ns,stamp_old_ns,virtual,view,u_old,v_old,u_current,v_current");
  std::getline(matched, line);
  EXPECT_EQ(line, "1000000003,1000000001,1,-1,1.5,2.0,3.0,4.0");
  std::getline(matched, line);
  EXPECT_EQ(line, "1000000003,1000000001,1,2,5.0,6.0,7.0,8.2");
  fs::remove_all(directory);
}

TEST(ResultFilesTest, AWithdrawnLoopIsNoAcceptedRow) {
  const auto loop = [](int old, int current, RejectReason reason) {
    LoopReport report;
    report.old = old;
    report.current = current;
    report.reason = reason;
    return report;
  };
  std::vector<LoopReport> rows;
  AddLoopRows({loop(1, 9, RejectReason::kInconsistent), loop(2, 9, RejectReason::kNone)}, &rows);
  AddLoopRows({loop(1, 9, RejectReason::kNone), loop(2, 9, RejectReason::kWithdrawn)}, &rows);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].reason, RejectReason::kInconsistent);
  EXPECT_EQ(rows[1].reason, RejectReason::kWithdrawn);
  EXPECT_TRUE(rows[2].accepted());
  EXPECT_THROW(AddLoopRows({loop(3, 9, RejectReason::kWithdrawn)}, &rows), CheckError);

  LoopRows short_rows;
  AddLoopRows({loop(2, 9, RejectReason::kNone)}, &short_rows);
  AddLoopRows({loop(2, 9, RejectReason::kWithdrawn)}, &short_rows);
  ASSERT_EQ(short_rows.size(), 1U);
  short_rows.ForEach([](const LoopRow& row) { EXPECT_EQ(row.reason, RejectReason::kWithdrawn); });
}

class CheckWritableTest : public TemporaryDirectoryTest {};

TEST_F(CheckWritableTest, MakesTheDirectoryAndLeavesNothingInIt) {
  CheckWritable(directory_ / "flights" / "one");
  EXPECT_TRUE(fs::is_empty(directory_ / "flights" / "one"));
}

TEST_F(CheckWritableTest, NamesADirectoryThatCannotBe) {
  const fs::path file = Write("file", "");
  EXPECT_EQ(MessageOf<InputError>([&] { CheckWritable(file / "out"); }),
            (file / "out").string() + ": files can't be written there");
}

}  // namespace
}  // namespace deja_view
