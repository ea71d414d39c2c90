// Whatever a message holds: a conversion either succeeds or throws InputError, and the assembler
// copes.

#include "deja_view/base/check.hpp"
#include "deja_view/host/keyframe_assembler.hpp"
#include "deja_view/ros/messages/conversions.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "fuzz.hpp"
#include <boost/make_shared.hpp>

namespace {

using namespace deja_view;

// Makes numbers of input bytes; zeros when they run out.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  bool empty() const { return size_ == 0; }

  template <typename T>
  T Take() {
    T value{};
    const std::size_t count = std::min(size_, sizeof(T));
    std::memcpy(&value, data_, count);
    data_ += count;
    size_ -= count;
    return value;
  }
  // Usually a small value, now and then any bits.
  double Number() {
    const auto kind = Take<std::uint8_t>();
    return kind < 200 ? (kind - 100) / 8.0 : Take<double>();
  }
  ros::Time Stamp() {
    const auto kind = Take<std::uint8_t>();
    return kind < 250 ? ros::Time(1000, kind % 16 * 50000000)
                      : ros::Time(Take<std::uint32_t>(), Take<std::uint32_t>() % 1000000000U);
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

nav_msgs::Odometry MakeOdometry(Bytes* bytes) {
  nav_msgs::Odometry message;
  message.header.stamp = bytes->Stamp();
  auto& pose = message.pose.pose;
  pose.orientation.w = 1;
  if (bytes->Take<std::uint8_t>() > 100) {
    for (double* value :
         {&pose.position.x, &pose.position.y, &pose.orientation.x, &pose.orientation.w}) {
      *value = bytes->Number();
    }
  }
  message.twist.twist.linear.x = bytes->Number();
  message.twist.twist.linear.y = bytes->Number();
  return message;
}

sensor_msgs::PointCloud MakePoints(Bytes* bytes) {
  sensor_msgs::PointCloud message;
  message.header.stamp = bytes->Stamp();
  message.points.resize(bytes->Take<std::uint8_t>() % 8);
  message.channels.resize(bytes->Take<std::uint8_t>() < 200 ? message.points.size()
                                                            : bytes->Take<std::uint8_t>() % 8);
  for (auto& point : message.points) {
    point.x = static_cast<float>(bytes->Number());
  }
  for (auto& channel : message.channels) {
    channel.values.resize(bytes->Take<std::uint8_t>() < 220 ? 5 : bytes->Take<std::uint8_t>() % 8);
    for (float& value : channel.values) {
      value = static_cast<float>(bytes->Number());
    }
  }
  return message;
}

sensor_msgs::ImageConstPtr MakeImage(Bytes* bytes) {
  static const char* const kNames[] = {
      "mono8", "8UC1", "rgb8", "bgra8", "mono16", "yuv", "", "8UC"};
  auto message = boost::make_shared<sensor_msgs::Image>();
  message->header.stamp = bytes->Stamp();
  message->encoding = kNames[bytes->Take<std::uint8_t>() % 8];
  message->is_bigendian = bytes->Take<std::uint8_t>();
  const bool is_wild = bytes->Take<std::uint8_t>() > 200;
  message->width = is_wild ? bytes->Take<std::uint32_t>() : bytes->Take<std::uint8_t>() % 12U;
  message->height = is_wild ? bytes->Take<std::uint32_t>() : bytes->Take<std::uint8_t>() % 12U;
  message->step = is_wild ? bytes->Take<std::uint32_t>() : bytes->Take<std::uint8_t>() % 60U;
  message->data.resize(bytes->Take<std::uint16_t>() % 1000);
  return message;
}

sensor_msgs::CompressedImageConstPtr MakeCompressedImage(Bytes* bytes) {
  auto message = boost::make_shared<sensor_msgs::CompressedImage>();
  message->header.stamp = bytes->Stamp();
  message->data.resize(bytes->Take<std::uint8_t>() % 64);
  for (std::uint8_t& byte : message->data) {
    byte = bytes->Take<std::uint8_t>();
  }
  return message;
}

void Expect(bool holds) {
  if (!holds) {
    std::abort();
  }
}

void FeedOne(Bytes* bytes, KeyframeAssembler* assembler) {
  switch (bytes->Take<std::uint8_t>() % 8) {
    case 0:
    case 1: {
      const StampedPose pose = FromOdometry(MakeOdometry(bytes), "pose");
      Expect(pose.pose.IsFinite());
      assembler->AddPose(pose.stamp_ns, pose.pose);
      break;
    }
    case 2:
    case 3: {
      const sensor_msgs::PointCloud message = MakePoints(bytes);
      assembler->AddPoints(ToNanoseconds(message.header.stamp),
                           FromKeyframePoints(message, "points"));
      break;
    }
    case 4: {
      const StampedPose pose = FromOdometry(MakeOdometry(bytes), "extrinsic");
      assembler->AddExtrinsic(pose.stamp_ns, pose.pose);
      break;
    }
    case 5:
      Expect(FromRelativePose(MakeOdometry(bytes), "relative").current >= 0);
      break;
    case 6: {
      const auto message = MakeCompressedImage(bytes);
      FromCompressedImage(message, "image")();
      break;
    }
    default: {
      const auto message = MakeImage(bytes);
      assembler->AddImage(
          ToNanoseconds(message->header.stamp), FromImage(message, "image"), message->data.size());
      break;
    }
  }
}

}  // namespace

namespace deja_view::fuzz {

std::vector<std::string> Seeds() {
  std::mt19937 random(1);
  std::vector<std::string> seeds(20, std::string(2000, '\0'));
  for (std::string& seed : seeds) {
    for (char& byte : seed) {
      byte = static_cast<char>(random());
    }
  }
  return seeds;
}

void RunOne(const std::string& input) {
  std::int64_t keyframes = 0;
  KeyframeAssemblerOptions options;
  options.image_memory_mb = 1e-3;
  options.max_pending = 4;
  KeyframeAssembler assembler(
      options,
      [&keyframes](const AssembledKeyframe& keyframe) {
        const cv::Mat image = keyframe.ToInput().image;
        Expect(image.type() == CV_8UC1 && !image.empty());
        ++keyframes;
      },
      nullptr);
  Bytes bytes(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  while (!bytes.empty()) {
    try {
      FeedOne(&bytes, &assembler);
    } catch (const InputError&) {
      // What bad messages are meant to end in.
    }
  }
  assembler.Flush();
  const AssemblerCounts& counts = assembler.counts();
  Expect(counts.keyframes == keyframes && keyframes <= counts.images && keyframes <= counts.poses);
}

}  // namespace deja_view::fuzz
