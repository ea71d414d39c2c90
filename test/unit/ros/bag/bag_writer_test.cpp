#include "deja_view/ros/bag/bag_writer.hpp"

#include "deja_view/ros/bag/bag_reader.hpp"

#include <iterator>

#include "bag_fixture.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

class BagWriterTest : public BagTest {
 protected:
  static std::ptrdiff_t FileCount(const fs::path& directory) {
    return std::distance(fs::directory_iterator(directory), fs::directory_iterator());
  }
};

TEST_F(BagWriterTest, AppearsUnderItsNameWhenClosed) {
  const fs::path path = Path("new/flight.bag");
  {
    BagWriter bag(path);
    bag.Write("/odometry", kStart, MakeOdometry(kStart, 1.5));
    EXPECT_FALSE(fs::exists(path));
    bag.Close();
  }
  EXPECT_EQ(FileCount(path.parent_path()), 1);
  const BagReader reader(path);
  reader.Read({"/odometry"}, [](const rosbag::MessageInstance& instance) {
    EXPECT_EQ(ToNanoseconds(instance.getTime()), kStart);
    EXPECT_EQ(Instantiate<nav_msgs::Odometry>(instance)->pose.pose.position.x, 1.5);
  });
}

TEST_F(BagWriterTest, LeavesNothingBehindUnlessClosed) {
  const fs::path path = WriteFlight("old.bag", 1);
  const auto size = fs::file_size(path);
  {
    BagWriter bag(path);
    bag.Write("/odometry", kStart, MakeOdometry(kStart, 1.5));
  }
  EXPECT_EQ(fs::file_size(path), size);
  EXPECT_EQ(FileCount(path.parent_path()), 1);
}

TEST_F(BagWriterTest, NamesAPathThatCannotBeWritten) {
  fs::create_directories(Path("taken.bag"));
  EXPECT_THAT(ErrorOf([&] { BagWriter bag(Path("taken.bag")); }), Says("taken.bag"));
  EXPECT_THAT(ErrorOf([&] { BagWriter bag("/proc/nowhere/x.bag"); }), Says("/proc/nowhere/x.bag"));
}

}  // namespace
}  // namespace deja_view
