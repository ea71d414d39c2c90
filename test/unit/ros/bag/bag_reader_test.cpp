#include "deja_view/ros/bag/bag_reader.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "bag_fixture.hpp"
#include <gmock/gmock.h>

#include <rosbag/bag.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class BagReaderTest : public BagTest {};

TEST_F(BagReaderTest, ListsTopicsAndReadsInOrderOfRecording) {
  const BagReader bag(WriteFlight("a.bag", 10));
  ASSERT_EQ(bag.topics().size(), 5U);
  EXPECT_EQ(bag.topics()[0].name, "/cam0/image_raw");
  EXPECT_EQ(bag.topics()[0].type, "sensor_msgs/Image");
  EXPECT_EQ(bag.topics()[0].messages, 10);
  EXPECT_TRUE(bag.HasTopic("/vins_estimator/odometry"));
  EXPECT_FALSE(bag.HasTopic("/vins_estimator"));

  std::vector<ros::Time> times;
  int images = 0;
  const std::int64_t count = bag.Read({"/cam0/image_raw", "/vins_estimator/odometry", "/none"},
                                      [&](const rosbag::MessageInstance& instance) {
                                        times.push_back(instance.getTime());
                                        if (instance.getTopic() == "/cam0/image_raw") {
                                          const auto image =
                                              Instantiate<sensor_msgs::Image>(instance);
                                          EXPECT_EQ(image->data.front(), images);
                                          ++images;
                                        }
                                      });
  EXPECT_EQ(count, 20);
  EXPECT_EQ(images, 10);
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
}

TEST_F(BagReaderTest, NamesWhatIsThereWhenATopicIsMissingOrOfAnotherType) {
  const BagReader bag(WriteFlight("a.bag", 2));
  EXPECT_THAT(ErrorOf([&] { bag.RequireTopic("/camera", {"sensor_msgs/Image"}); }),
              AllOf(HasSubstr("a.bag"),
                    HasSubstr("'/camera'"),
                    HasSubstr("/cam0/image_raw (sensor_msgs/Image, 2)")));
  EXPECT_THAT(ErrorOf([&] { bag.RequireTopic("/vins_estimator/odometry", {"sensor_msgs/Image"}); }),
              AllOf(HasSubstr("nav_msgs/Odometry"), HasSubstr("expected sensor_msgs/Image")));
  EXPECT_THAT(ErrorOf([&] {
                bag.Read({"/cam0/image_raw"}, [](const rosbag::MessageInstance& instance) {
                  Instantiate<nav_msgs::Odometry>(instance);
                });
              }),
              AllOf(HasSubstr("/cam0/image_raw"), HasSubstr("expected nav_msgs/Odometry")));
}

TEST_F(BagReaderTest, ExceptionsOfTheVisitorPassThrough) {
  const BagReader bag(WriteFlight("a.bag", 2));
  EXPECT_THROW(bag.Read({"/cam0/image_raw"},
                        [](const rosbag::MessageInstance&) { throw std::out_of_range("mine"); }),
               std::out_of_range);
}

TEST_F(BagReaderTest, RefusesWhatIsNoBag) {
  EXPECT_THAT(ErrorOf([&] { BagReader(Path("none.bag")); }),
              AllOf(HasSubstr("none.bag"), HasSubstr("No such file")));
  EXPECT_THAT(ErrorOf([&] { BagReader(Path("")); }), HasSubstr("is a directory"));
  std::ofstream(Path("text.bag")) << "hello\n";
  EXPECT_THAT(ErrorOf([&] { BagReader(Path("text.bag")); }), HasSubstr("text.bag"));
  std::ofstream(Path("empty.bag"));
  EXPECT_THAT(ErrorOf([&] { BagReader(Path("empty.bag")); }), HasSubstr("empty.bag"));
}

TEST_F(BagReaderTest, TellsAnUnclosedBagFromABrokenOne) {
  const BagWriter unclosed(Path("b.bag"));
  EXPECT_THAT(ErrorOf([&] { BagReader(Path("b.bag.deja_view_tmp" + std::to_string(::getpid()))); }),
              HasSubstr("rosbag reindex"));
}

// Overwrites bytes from the first place of `mark` on.
void Alter(const fs::path& path, const std::string& mark, std::size_t after, std::uint32_t value) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const std::size_t at = bytes.find(mark);
  ASSERT_NE(at, std::string::npos);
  std::memcpy(&bytes[at + after], &value, sizeof(value));
  std::ofstream(path, std::ios::binary) << bytes;
}

TEST_F(BagReaderTest, MakesNoRoomForWhatAMessageDoesNotHave) {
  const fs::path path = WriteFlight("a.bag", 3);
  // The lengths of encoding and data are around it: is_bigendian and step lie between.
  Alter(path, "mono8", 5 + 1 + 4, 0xF0000000);
  const BagReader bag(path);
  EXPECT_THAT(ErrorOf([&] {
                bag.Read({"/cam0/image_raw"}, [](const rosbag::MessageInstance& instance) {
                  Instantiate<sensor_msgs::Image>(instance);
                });
              }),
              AllOf(HasSubstr("a.bag"), HasSubstr("/cam0/image_raw"), HasSubstr("'data'")));
}

TEST_F(BagReaderTest, MakesNoRoomForWhatAChunkCanNotHold) {
  for (const auto kind : {rosbag::compression::BZ2, rosbag::compression::LZ4}) {
    rosbag::Bag packed;
    packed.open(Path("packed.bag").string(), rosbag::bagmode::Write);
    packed.setCompression(kind);
    packed.write("/image", ToRosTime(kStart), MakeImage(kStart, 7));
    packed.close();
    EXPECT_EQ(BagReader(Path("packed.bag")).topics().size(), 1U);
    Alter(Path("packed.bag"), "size=", 5, 0xF0000000);
    EXPECT_THAT(ErrorOf([&] { BagReader(Path("packed.bag")); }),
                AllOf(HasSubstr("packed.bag"), HasSubstr("unpacked")));
  }
}

// Each listing would have its index read anew.
TEST_F(BagReaderTest, AChunkIsListedOnce) {
  rosbag::Bag bag;
  bag.open(Path("two.bag").string(), rosbag::bagmode::Write);
  bag.setChunkThreshold(100);
  for (int i = 0; i < 2; ++i) {
    bag.write("/image", ToRosTime(kStart + i), MakeImage(kStart + i, 7));
  }
  bag.close();
  EXPECT_EQ(BagReader(Path("two.bag")).topics().size(), 1U);
  std::ifstream in(Path("two.bag"), std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const std::string name = "chunk_pos=";
  const std::size_t first = bytes.find(name);
  const std::size_t second = bytes.find(name, first + 1);
  ASSERT_NE(second, std::string::npos);
  bytes.replace(second, name.size() + 8, bytes, first, name.size() + 8);
  std::ofstream(Path("two.bag"), std::ios::binary) << bytes;
  EXPECT_THAT(ErrorOf([&] { BagReader(Path("two.bag")); }),
              AllOf(HasSubstr("two.bag"), HasSubstr("not listed yet")));
}

TEST_F(BagReaderTest, EveryTruncationIsAnError) {
  const fs::path path = WriteFlight("a.bag", 3);
  const auto size = fs::file_size(path);
  for (std::uintmax_t kept = 0; kept < size; kept += 977) {
    fs::copy_file(path, Path("cut.bag"), fs::copy_options::overwrite_existing);
    fs::resize_file(Path("cut.bag"), kept);
    EXPECT_THAT(ErrorOf([&] { BagReader(Path("cut.bag")); }), HasSubstr("cut.bag")) << kept;
  }
}

}  // namespace
}  // namespace deja_view
