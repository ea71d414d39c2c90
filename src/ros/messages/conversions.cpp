#include "deja_view/ros/messages/conversions.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/quote.hpp"
#include "deja_view/io/encoded_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <sensor_msgs/image_encodings.h>

namespace deja_view {
namespace {

constexpr std::int64_t kNanoseconds = 1000000000;
constexpr const char* kWorld = "world";
constexpr std::size_t kPointChannels = 5;           // x_n, y_n, u, v, feature id
constexpr float kBehindEveryTrack = 2147483520.0F;  // the largest below 2^31, where ints end
constexpr std::uint32_t kMaxImageSide = 32768;
constexpr std::int64_t kMaxEncodedPixels = std::int64_t{1} << 26;

struct Encoding {
  const char* name;
  int type;     // OpenCV's; 16 bits as two bytes, as rows may start at odd addresses
  int to_grey;  // -1 for none
  int to_bgr;   // -1 for none
};

constexpr std::array<Encoding, 8> kEncodings = {{
    {"mono8", CV_8UC1, -1, -1},
    {"8UC1", CV_8UC1, -1, -1},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY, cv::COLOR_RGB2BGR},
    {"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY, -1},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY, cv::COLOR_RGBA2BGR},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY, cv::COLOR_BGRA2BGR},
    {"mono16", CV_8UC2, -1, -1},
    {"16UC1", CV_8UC2, -1, -1},
}};

const Encoding& FindEncoding(const std::string& name, const std::string& topic) {
  for (const Encoding& encoding : kEncodings) {
    if (name == encoding.name) {
      return encoding;
    }
  }
  ThrowInputError(
      "{}: image encoding {}: expected mono8, 8UC1, rgb8, bgr8, rgba8, bgra8, mono16 or 16UC1",
      topic,
      Quote(name));
}

void CheckImageSize(const sensor_msgs::Image& image, int type, const std::string& topic) {
  if (image.width == 0 || image.height == 0 || image.width > kMaxImageSide ||
      image.height > kMaxImageSide) {
    ThrowInputError("{}: image of {} x {} px: expected 1 to {} px a side",
                    topic,
                    image.width,
                    image.height,
                    kMaxImageSide);
  }
  const std::uint64_t row = std::uint64_t{image.width} * CV_ELEM_SIZE(type);
  if (image.step < row) {
    ThrowInputError("{}: image step {}: expected at least {} bytes for {} px of {}",
                    topic,
                    image.step,
                    row,
                    image.width,
                    image.encoding);
  }
  const std::uint64_t size = std::uint64_t{image.step} * image.height;
  if (image.data.size() < size) {
    ThrowInputError("{}: {} bytes of image data: expected {} ({} rows of {})",
                    topic,
                    image.data.size(),
                    size,
                    image.height,
                    image.step);
  }
}

void CheckSizeIs(cv::Size found, cv::Size expected, const std::string& topic) {
  if (!expected.empty() && found != expected) {
    ThrowInputError("{}: image of {} x {} px: expected {} x {}, the camera's",
                    topic,
                    found.width,
                    found.height,
                    expected.width,
                    expected.height);
  }
}

[[noreturn]] void ThrowUndecodable(const sensor_msgs::CompressedImage& image,
                                   const std::string& topic) {
  ThrowInputError("{}: {} bytes of format {} can't be decoded: expected JPEG or PNG",
                  topic,
                  image.data.size(),
                  Quote(image.format));
}

// A few bytes may state a size that would take gigabytes to decode.
cv::Size CheckedEncodedSize(const sensor_msgs::CompressedImage& image, const std::string& topic) {
  if (image.data.empty()) {
    ThrowInputError("{}: compressed image without data: expected JPEG or PNG", topic);
  }
  const cv::Size size = EncodedSize(image.data);
  if (size.empty()) {
    ThrowUndecodable(image, topic);
  }
  if (std::int64_t{size.width} * size.height > kMaxEncodedPixels) {
    ThrowInputError("{}: image of {} x {} px: expected at most {} px",
                    topic,
                    size.width,
                    size.height,
                    kMaxEncodedPixels);
  }
  return size;
}

cv::Mat Grey16(const cv::Mat& image, bool is_bigendian) {
  cv::Mat grey(image.rows, image.cols, CV_8UC1);
  const int high = is_bigendian ? 0 : 1;
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* from = image.ptr<std::uint8_t>(y);
    std::uint8_t* to = grey.ptr<std::uint8_t>(y);
    for (int x = 0; x < image.cols; ++x) {
      to[x] = from[2 * x + high];
    }
  }
  return grey;
}

cv::Mat Decode(const sensor_msgs::Image& message, const Encoding& encoding, PixelKind kind) {
  // OpenCV has no const view; the data is only read.
  auto* data = const_cast<std::uint8_t*>(message.data.data());
  const cv::Mat view(static_cast<int>(message.height),
                     static_cast<int>(message.width),
                     encoding.type,
                     data,
                     message.step);
  if (encoding.type == CV_8UC2) {
    return Grey16(view, message.is_bigendian != 0);
  }
  const int conversion = kind == PixelKind::kGrey ? encoding.to_grey : encoding.to_bgr;
  cv::Mat pixels;
  if (conversion < 0) {
    view.copyTo(pixels);
  } else {
    cv::cvtColor(view, pixels, conversion);
  }
  return pixels;
}

std::int64_t FeatureId(float value) {
  // VINS-Mono sends ids as floats: exact up to 2^24.
  return std::isfinite(value) && std::abs(value) < 9.0e15F ? std::llround(value) : -1;
}

}  // namespace

// A message may say any number of nanoseconds: up to four seconds beyond what can be written again.
std::int64_t ToNanoseconds(const ros::Time& stamp) {
  constexpr std::int64_t kLatest =
      (std::int64_t{std::numeric_limits<std::uint32_t>::max()} + 1) * kNanoseconds - 1;
  return std::min(kLatest, std::int64_t{stamp.sec} * kNanoseconds + stamp.nsec);
}

ros::Time ToRosTime(std::int64_t stamp_ns) {
  DEJA_VIEW_CHECK_OP(stamp_ns, >=, 0);
  DEJA_VIEW_CHECK_OP(
      stamp_ns / kNanoseconds, <=, std::int64_t{std::numeric_limits<std::uint32_t>::max()});
  return {static_cast<std::uint32_t>(stamp_ns / kNanoseconds),
          static_cast<std::uint32_t>(stamp_ns % kNanoseconds)};
}

Rigid3 FromPose(const geometry_msgs::Pose& message, const std::string& topic) {
  const auto& p = message.position;
  const auto& o = message.orientation;
  Rigid3 pose{Eigen::Quaterniond(o.w, o.x, o.y, o.z), Eigen::Vector3d(p.x, p.y, p.z)};
  if (!pose.IsFinite()) {
    ThrowInputError(
        "{}: pose position ({}, {}, {}), orientation ({}, {}, {}, {}): expected finite numbers",
        topic,
        p.x,
        p.y,
        p.z,
        o.x,
        o.y,
        o.z,
        o.w);
  }
  const double norm = pose.q.norm();
  if (!(std::abs(norm - 1.0) <= 0.01)) {
    ThrowInputError(
        "{}: orientation ({}, {}, {}, {}) of norm {}: expected 1", topic, o.x, o.y, o.z, o.w, norm);
  }
  pose.q.normalize();
  return pose;
}

geometry_msgs::Pose ToPose(const Rigid3& pose) {
  geometry_msgs::Pose message;
  message.position.x = pose.t.x();
  message.position.y = pose.t.y();
  message.position.z = pose.t.z();
  message.orientation.x = pose.q.x();
  message.orientation.y = pose.q.y();
  message.orientation.z = pose.q.z();
  message.orientation.w = pose.q.w();
  return message;
}

bool IsUninitialised(const nav_msgs::Odometry& message) {
  const auto& q = message.pose.pose.orientation;
  return q.x == 0 && q.y == 0 && q.z == 0 && q.w == 0;
}

StampedPose FromOdometry(const nav_msgs::Odometry& message, const std::string& topic) {
  return {ToNanoseconds(message.header.stamp), FromPose(message.pose.pose, topic)};
}

std::vector<TrackedPoint> FromKeyframePoints(const sensor_msgs::PointCloud& message,
                                             const std::string& topic) {
  if (message.channels.size() != message.points.size()) {
    ThrowInputError("{}: {} channels for {} points: expected one channel per point",
                    topic,
                    message.channels.size(),
                    message.points.size());
  }
  std::vector<TrackedPoint> points;
  points.reserve(message.points.size());
  for (std::size_t i = 0; i < message.points.size(); ++i) {
    const std::vector<float>& values = message.channels[i].values;
    if (values.size() < kPointChannels) {
      ThrowInputError("{}: {} values in the channel of point {}: expected {} (x_n, y_n, u, v, id)",
                      topic,
                      values.size(),
                      i,
                      kPointChannels);
    }
    TrackedPoint point;
    point.p_W = {message.points[i].x, message.points[i].y, message.points[i].z};
    point.pixel = {values[2], values[3]};
    point.feature_id = FeatureId(values[4]);
    if (point.p_W.allFinite() && point.pixel.allFinite()) {
      points.push_back(point);
    }
  }
  return points;
}

RelativePoseUpdate FromRelativePose(const nav_msgs::Odometry& message, const std::string& topic) {
  RelativePoseUpdate update;
  update.stamp_current_ns = ToNanoseconds(message.header.stamp);
  update.T_Bold_Bcurrent = FromPose(message.pose.pose, topic);
  const double yaw_deg = message.twist.twist.linear.x;
  const double index = message.twist.twist.linear.y;
  if (!std::isfinite(yaw_deg)) {
    ThrowInputError("{}: relative yaw {}: expected a finite number of degrees", topic, yaw_deg);
  }
  if (!(index >= 0 && index <= std::numeric_limits<int>::max())) {
    ThrowInputError("{}: keyframe index {}: expected 0 or more", topic, index);
  }
  update.relative_yaw = ToRadians(yaw_deg);
  update.current = static_cast<int>(std::lround(index));
  return update;
}

nav_msgs::Odometry ToOdometry(const StampedPose& pose) {
  nav_msgs::Odometry message;
  message.header.stamp = ToRosTime(pose.stamp_ns);
  message.header.frame_id = kWorld;
  message.child_frame_id = kWorld;  // as VINS-Mono has it
  message.pose.pose = ToPose(pose.pose);
  return message;
}

sensor_msgs::PointCloud ToKeyframePoints(std::int64_t stamp_ns,
                                         const std::vector<TrackedPoint>& points,
                                         const Camera& camera) {
  sensor_msgs::PointCloud message;
  message.header.stamp = ToRosTime(stamp_ns);
  message.header.frame_id = kWorld;
  for (const TrackedPoint& tracked : points) {
    geometry_msgs::Point32 point;
    point.x = static_cast<float>(tracked.p_W.x());
    point.y = static_cast<float>(tracked.p_W.y());
    point.z = static_cast<float>(tracked.p_W.z());
    message.points.push_back(point);
    const Eigen::Vector3d ray = camera.Unproject(tracked.pixel.cast<double>());
    sensor_msgs::ChannelFloat32 channel;
    channel.values = {static_cast<float>(ray.x() / ray.z()),
                      static_cast<float>(ray.y() / ray.z()),
                      tracked.pixel.x(),
                      tracked.pixel.y(),
                      static_cast<float>(tracked.feature_id)};
    message.channels.push_back(std::move(channel));
  }
  return message;
}

sensor_msgs::PointCloud ToMatchPoints(const Relocalisation& relocalisation,
                                      int current,
                                      std::int64_t stamp_current_ns,
                                      const std::string& frame_id) {
  sensor_msgs::PointCloud message;
  message.header.stamp = ToRosTime(stamp_current_ns);
  message.header.frame_id = frame_id;
  for (const RelocalisationPoint& match : relocalisation.points) {
    geometry_msgs::Point32 point;
    point.x = static_cast<float>(match.normalised_old.x());
    point.y = static_cast<float>(match.normalised_old.y());
    point.z = static_cast<float>(match.feature_id);
    message.points.push_back(point);
  }
  std::sort(message.points.begin(), message.points.end(), [](const auto& a, const auto& b) {
    return a.z < b.z;
  });
  message.points.emplace_back().z = kBehindEveryTrack;
  const Rigid3& T = relocalisation.T_M_Bold;
  sensor_msgs::ChannelFloat32 channel;
  for (const double value : Numbers(T.t)) {
    channel.values.push_back(static_cast<float>(value));
  }
  for (const double value : ScalarFirst(T.q)) {
    channel.values.push_back(static_cast<float>(value));
  }
  channel.values.push_back(static_cast<float>(current));
  message.channels.push_back(std::move(channel));
  return message;
}

ImageSource FromImage(const sensor_msgs::ImageConstPtr& message,
                      const std::string& topic,
                      cv::Size size,
                      PixelKind kind) {
  const Encoding& encoding = FindEncoding(message->encoding, topic);
  CheckImageSize(*message, encoding.type, topic);
  CheckSizeIs({static_cast<int>(message->width), static_cast<int>(message->height)}, size, topic);
  return [message, &encoding, kind] { return Decode(*message, encoding, kind); };
}

ImageSource FromCompressedImage(const sensor_msgs::CompressedImageConstPtr& message,
                                const std::string& topic,
                                cv::Size size,
                                PixelKind kind) {
  CheckSizeIs(CheckedEncodedSize(*message, topic), size, topic);
  return [message, topic, kind] {
    cv::Mat image;
    try {
      image = cv::imdecode(message->data,
                           kind == PixelKind::kGrey ? cv::IMREAD_GRAYSCALE : cv::IMREAD_ANYCOLOR);
    } catch (const cv::Exception&) {
      image.release();
    }
    if (image.empty()) {
      ThrowUndecodable(*message, topic);
    }
    return image;
  };
}

sensor_msgs::Image ToImage(const cv::Mat& image,
                           std::int64_t stamp_ns,
                           const std::string& frame_id) {
  DEJA_VIEW_CHECK(image.type() == CV_8UC1 || image.type() == CV_8UC3);
  sensor_msgs::Image message;
  message.header.stamp = ToRosTime(stamp_ns);
  message.header.frame_id = frame_id;
  message.height = static_cast<std::uint32_t>(image.rows);
  message.width = static_cast<std::uint32_t>(image.cols);
  message.encoding = image.type() == CV_8UC1 ? "mono8" : "bgr8";
  message.step = static_cast<std::uint32_t>(image.cols * static_cast<int>(image.elemSize()));
  message.data.reserve(std::size_t{message.step} * message.height);
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y);
    message.data.insert(message.data.end(), row, row + message.step);
  }
  return message;
}

}  // namespace deja_view
