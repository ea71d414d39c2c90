#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/view_flight.hpp"

#include <fstream>
#include <set>

#include "bag_fixture.hpp"
#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

class ViewFlightImagesTest : public BagTest {
 protected:
  fs::path WriteImage(const std::string& name, const cv::Mat& image) const {
    fs::create_directories(Path("images"));
    const fs::path path = Path("images") / name;
    EXPECT_TRUE(cv::imwrite(path.string(), image));
    return path;
  }
  std::shared_ptr<const ViewFlight> Open() const {
    return OpenImageFlight(Path("images"), "/cam0/image_raw", camera_);
  }
  std::string OpenError() const {
    return ErrorOf([&] { Open(); });
  }

  cv::Mat grey_{12, 16, CV_8UC1, cv::Scalar(77)};
  std::shared_ptr<const Camera> camera_ =
      std::make_shared<PinholeCamera>(PinholeParameters{16, 12, 10, 10, 7.5, 5.5, 0, 0, 0, 0});
};

TEST_F(ViewFlightImagesTest, BecomesABagOfItsImages) {
  WriteImage("2000000001.png", grey_);
  WriteImage("0.500000000.png", cv::Mat(12, 16, CV_8UC3, cv::Scalar(10, 20, 30)));
  WriteImage("1000000000.png", cv::Mat(12, 16, CV_16UC1, cv::Scalar(0x3456)));
  const auto flight = Open();
  EXPECT_EQ(flight->Describe(), "/cam0/image_raw sensor_msgs/Image 3\n");
  EXPECT_TRUE(flight->HasTopic("/cam0/image_raw"));
  EXPECT_FALSE(flight->HasTopic(VioTopics().keyframe_pose));
  flight->CheckContent(2);
  BagWriter bag(Path("out.bag"));
  flight->ReadAll([&](std::int64_t, const ViewFlight::WriteMessage& write) { write(&bag); });
  bag.Close();

  std::vector<std::int64_t> times;
  std::vector<std::string> encodings;
  std::vector<int> greys;
  BagReader(Path("out.bag")).ReadAll([&](const rosbag::MessageInstance& m) {
    const auto image = Instantiate<sensor_msgs::Image>(m);
    EXPECT_EQ(m.getTime(), image->header.stamp);
    EXPECT_EQ(image->header.frame_id, "cam0");
    times.push_back(ToNanoseconds(m.getTime()));
    encodings.push_back(image->encoding);
    greys.push_back(FromImage(image, "")().at<std::uint8_t>(5, 5));
  });
  EXPECT_EQ(times, (std::vector<std::int64_t>{500000000, 1000000000, 2000000001}));
  EXPECT_EQ(encodings, (std::vector<std::string>{"bgr8", "mono8", "mono8"}));
  EXPECT_EQ(greys, (std::vector<int>{22, 0x34, 77}));
}

TEST_F(ViewFlightImagesTest, HandsOverTheImagesThatAreWanted) {
  for (int i = 1; i <= 5; ++i) {
    WriteImage(std::to_string(i) + ".png", i * grey_ / 77);
  }
  const auto flight = Open();
  EXPECT_EQ(flight->ListImages("/cam0/image_raw").size(), 5U);
  std::vector<std::int64_t> seen;
  flight->ReadImages(
      "/cam0/image_raw", {4, 2, 9}, [&](std::int64_t time_ns, const DecodedImage& decoded) {
        EXPECT_EQ(decoded.image.at<std::uint8_t>(0, 0), time_ns);
        seen.push_back(time_ns);
      });
  EXPECT_EQ(seen, (std::vector<std::int64_t>{2, 4}));
  EXPECT_THAT(ErrorOf([&] { flight->ListImages("/other"); }), Says("'/cam0/image_raw'"));
  EXPECT_THAT(ErrorOf([&] { flight->KeyframeStamps({}); }), Says("no keyframes"));
  EXPECT_TRUE(flight->ReadTrackedPoints({}, *camera_, {}).empty());
}

TEST_F(ViewFlightImagesTest, ErrorsNameTheFile) {
  fs::create_directories(Path("images"));
  EXPECT_THAT(OpenError(), Says("holds no image"));
  const fs::path good = WriteImage("1000000000.png", grey_);
  const fs::path unnamed = WriteImage("frame7.png", grey_);
  EXPECT_THAT(OpenError(), Says(unnamed.string(), "stamp"));
  fs::remove(unnamed);
  for (const char* name : {"0.png", "4294967296000000000.png"}) {
    const fs::path path = WriteImage(name, grey_);
    EXPECT_THAT(OpenError(), Says(path.string(), "as ROS can tell"));
    fs::remove(path);
  }
  const fs::path large = WriteImage("4294967295999999999.png", cv::Mat(24, 32, CV_8UC1, 1.0));
  EXPECT_THAT(ErrorOf([&] { Open()->CheckContent(1); }),
              Says(large.string(), "32 x 24", "16 x 12"));
  std::ofstream(large) << "no picture";
  EXPECT_THAT(ErrorOf([&] { Open()->CheckContent(1); }), Says(large.string(), "can't be read"));
}

}  // namespace
}  // namespace deja_view
