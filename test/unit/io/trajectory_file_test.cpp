#include "deja_view/io/trajectory_file.hpp"

#include "deja_view/base/check.hpp"

#include "temporary_directory.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

class TrajectoryFileTest : public TemporaryDirectoryTest {
 protected:
  std::string ErrorOf(const std::string& text) const {
    const auto path = Write("poses.txt", text);
    return MessageOf<InputError>([&] { ReadTrajectoryFile(path); });
  }
};

TEST_F(TrajectoryFileTest, TellsTumFromCsvByItsContent) {
  const auto tum = ReadTrajectoryFile(Write("a.csv", "# t\n1.5 1 2 3 0 0 0 1\n"));
  EXPECT_EQ(tum.format, TrajectoryFormat::kTum);
  EXPECT_EQ(tum.trajectory.stamps_ns.at(0), 1500000000);
  const auto csv = ReadTrajectoryFile(Write("a.txt", "1500000000,1,2,3,1,0,0,0\n"));
  EXPECT_EQ(csv.format, TrajectoryFormat::kCsv);
  EXPECT_EQ(csv.trajectory.stamps_ns.at(0), 1500000000);
  EXPECT_FALSE(csv.is_of_camera);
}

TEST_F(TrajectoryFileTest, ReadsWhatVinsMonoWrites) {
  // vins_result_no_loop.csv has velocities; both end their lines with a comma.
  const auto no_loop =
      ReadTrajectoryFile(Write("vins_result_no_loop.csv",
                               "1403636626258812928,0.1,0.2,0.3,0.5,0.5,-0.5,0.5,"
                               "0.01,0.02,0.03,\n"
                               "1403636626358812928,1,2,3,1.00000,0,0,0,0,0,0,\n"));
  ASSERT_EQ(no_loop.trajectory.size(), 2U);
  EXPECT_EQ(no_loop.trajectory.stamps_ns[0], 1403636626258812928);
  EXPECT_EQ(no_loop.trajectory.poses[0].t, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(no_loop.trajectory.poses[0].q.w(), 0.5);
  EXPECT_EQ(no_loop.trajectory.poses[0].q.y(), -0.5);
  const auto loop = ReadTrajectoryFile(
      Write("vins_result_loop.csv", "1403636626258812928,1,2,3,0.00000,0,0.6,0.8,\n"));
  EXPECT_EQ(loop.trajectory.poses.at(0).q.z(), 0.8);
}

TEST_F(TrajectoryFileTest, ReadsEurocsFolder) {
  Write("V1_01/mav0/state_groundtruth_estimate0/data.csv",
        "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y []\r\n"
        "1403715274302142976,0.878612,2.142470,0.947262,0.060514,-0.828459,-0.058956,-0.553641,"
        "0.009474,-0.014009,-0.002145,-0.002229,0.0207,0.0766,-0.0135,0.1382,0.0589\r\n");
  const auto file = ReadTrajectoryFile(directory_ / "V1_01");
  ASSERT_EQ(file.trajectory.size(), 1U);
  EXPECT_NEAR(file.trajectory.poses[0].q.x(), -0.828459, 1e-5);
  EXPECT_EQ(ReadTrajectoryFile(directory_ / "V1_01/mav0").trajectory.size(), 1U);
  EXPECT_EQ(FindAslImages(directory_ / "V1_01"), directory_ / "V1_01");
  Write("V1_01/mav0/cam0/data/1.png", "");
  EXPECT_EQ(FindAslImages(directory_ / "V1_01"), directory_ / "V1_01/mav0/cam0/data");
}

TEST_F(TrajectoryFileTest, ReadsCamerasOfAColmapModel) {
  Write("model/cameras.txt", "1 PINHOLE 640 480 500 500 320 240\n");
  Write("model/images.txt", "1 1 0 0 0 -1 -2 -3 1 2000.jpg\n\n2 1 0 0 0 0 0 0 1 1000.jpg\n\n");
  Write("model/points3D.txt", "");
  const auto file = ReadTrajectoryFile(directory_ / "model");
  EXPECT_EQ(file.format, TrajectoryFormat::kColmap);
  EXPECT_TRUE(file.is_of_camera);
  EXPECT_EQ(file.trajectory.stamps_ns, (std::vector<std::int64_t>{1000, 2000}));
  EXPECT_EQ(file.trajectory.poses[1].t, Eigen::Vector3d(1, 2, 3));
}

TEST_F(TrajectoryFileTest, NamesWhatIsWrong) {
  ExpectErrors([&](const std::string& text) { return ErrorOf(text); },
               {{"1,1,2,3,1,0,0\n", "poses.txt:1: expected 'stamp_ns, tx"},
                {"#\n1.5,1,2,3,1,0,0,0\n", ":2: expected 'stamp_ns, tx"},
                {"1,1,2,nan,1,0,0,0\n", ":1: expected 'stamp_ns, tx"},
                {"1,1,2,3,1,1,0,0\n", ":1: expected a unit quaternion"},
                {"2,1,2,3,1,0,0,0\n2,1,2,3,1,0,0,0\n", ":2: expected a stamp later"},
                {"# nothing\n", "holds no pose"}});
  EXPECT_THAT(MessageOf<InputError>([&] { ReadTrajectoryFile(directory_); }),
              Says("state_groundtruth_estimate0"));
  EXPECT_THAT(MessageOf<InputError>([&] { ReadTrajectoryFile(directory_ / "a.bag"); }),
              Says("a.bag", "topic"));
  EXPECT_THAT(MessageOf<InputError>([&] { ReadTrajectoryFile(directory_ / "none"); }),
              Says("can't be opened"));
}

}  // namespace
}  // namespace deja_view
