#include "report/report_pictures.hpp"

#include "deja_view/host/keyframe_assembler.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/bag_replay.hpp"
#include "deja_view/ros/messages/conversions.hpp"
#include "deja_view/ros/messages/virtual_frame_conversion.hpp"

#include <map>
#include <optional>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

namespace deja_view {
namespace {

using Wanted = std::map<std::pair<std::int64_t, int>, std::pair<std::int64_t, int>>;

/// VIOs round stamps: what is wanted by the key that is the same for both.
Wanted ByKey(const std::set<std::pair<std::int64_t, int>>& wanted) {
  Wanted by_key;
  for (const auto& [stamp_ns, view] : wanted) {
    by_key[{KeyframeAssembler::Key(stamp_ns), view}] = {stamp_ns, view};
  }
  return by_key;
}

report::Picture MakePicture(const cv::Mat& image) {
  constexpr int kQuality = 72;
  cv::Mat small;
  cv::resize(image, small, {}, 0.5, 0.5, cv::INTER_AREA);
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", small, bytes, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  return {{bytes.begin(), bytes.end()},
          static_cast<double>(image.cols),
          static_cast<double>(image.rows)};
}

std::int64_t StampOf(const rosbag::MessageInstance& instance) {
  return ToNanoseconds(instance.isType<sensor_msgs::Image>()
                           ? Instantiate<sensor_msgs::Image>(instance)->header.stamp
                           : Instantiate<sensor_msgs::CompressedImage>(instance)->header.stamp);
}

cv::Mat Decode(const rosbag::MessageInstance& instance) {
  const std::string topic = instance.getTopic();
  return instance.isType<sensor_msgs::Image>()
             ? FromImage(Instantiate<sensor_msgs::Image>(instance), topic)()
             : FromCompressedImage(Instantiate<sensor_msgs::CompressedImage>(instance), topic)();
}

void ReadBag(const BagReader& bag,
             const std::string& image_topic,
             const Wanted& wanted,
             report::Pictures* pictures) {
  const std::string views = VioTopics{}.virtual_frame;
  bag.RequireTopic(image_topic, {"sensor_msgs/Image", "sensor_msgs/CompressedImage"});
  bag.Read({image_topic, views}, [&](const rosbag::MessageInstance& instance) {
    const bool is_view = instance.getTopic() == views;
    const auto message = is_view ? Instantiate<VirtualFrame>(instance) : nullptr;
    const std::int64_t stamp_ns =
        is_view ? ToNanoseconds(message->header.stamp) : StampOf(instance);
    const auto found =
        wanted.find({KeyframeAssembler::Key(stamp_ns), is_view ? message->view_index : -1});
    if (found == wanted.end() || pictures->count(found->second) > 0) {
      return;
    }
    const cv::Mat image = is_view ? FromVirtualFrame(*message, views).image : Decode(instance);
    if (!image.empty()) {
      (*pictures)[found->second] = MakePicture(image);
    }
  });
}

}  // namespace

report::Pictures ReadPictures(const std::vector<std::filesystem::path>& bags,
                              const std::string& image_topic,
                              const std::set<std::pair<std::int64_t, int>>& wanted) {
  const Wanted by_key = ByKey(wanted);
  report::Pictures pictures;
  for (const std::filesystem::path& bag : bags) {
    ReadBag(BagReader(bag), image_topic, by_key, &pictures);
  }
  return pictures;
}

}  // namespace deja_view
