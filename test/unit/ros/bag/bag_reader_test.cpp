#include "deja_view/ros/bag/bag_reader.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "bag_fixture.hpp"
#include <gmock/gmock.h>

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
              AllOf(HasSubstr("none.bag"), HasSubstr("no such file")));
  EXPECT_THAT(ErrorOf([&] { BagReader(Path("")); }), HasSubstr("no such file"));
  std::ofstream(Path("text.bag")) << "hello\n";
  EXPECT_THAT(ErrorOf([&] { BagReader(Path("text.bag")); }), HasSubstr("text.bag"));
  std::ofstream(Path("empty.bag"));
  EXPECT_THAT(ErrorOf([&] { BagReader(Path("empty.bag")); }), HasSubstr("empty.bag"));
}

TEST_F(BagReaderTest, TellsAnUnclosedBagFromABrokenOne) {
  const BagWriter unclosed(Path("b.bag"));
  EXPECT_THAT(ErrorOf([&] { BagReader(Path("b.bag.tmp" + std::to_string(::getpid()))); }),
              HasSubstr("rosbag reindex"));
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
