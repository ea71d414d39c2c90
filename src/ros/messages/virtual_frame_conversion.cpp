#include "deja_view/ros/messages/virtual_frame_conversion.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/quote.hpp"
#include "deja_view/camera/camera_parameters.hpp"
#include "deja_view/io/encoded_image.hpp"
#include "deja_view/ros/messages/conversions.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace deja_view {
namespace {

constexpr std::size_t kMaxKeypoints = 65535;
constexpr int kMaxSide = 32768;
constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 26;

cv::Size SizeOf(const Camera& camera) {
  return {camera.width(), camera.height()};
}

void CheckView(const VirtualView& view) {
  DEJA_VIEW_CHECK(view.camera != nullptr);
  DEJA_VIEW_CHECK(!view.image.empty() || !view.features.descriptor.empty());
  const cv::Size size = SizeOf(*view.camera);
  DEJA_VIEW_CHECK(view.image.empty() ||
                  (view.image.type() == CV_8UC1 && view.image.size() == size));
  DEJA_VIEW_CHECK(view.depth_mm.empty() ||
                  (view.depth_mm.type() == CV_16UC1 && view.depth_mm.size() == size));
  DEJA_VIEW_CHECK(view.certainty.empty() ||
                  (view.certainty.type() == CV_8UC1 && view.certainty.size() == size));
  const std::size_t count = view.features.features.keypoints.size();
  DEJA_VIEW_CHECK_OP(view.features.features.descriptors.size(), ==, count);
  DEJA_VIEW_CHECK_OP(view.features.depth_m.size(), ==, count);
  DEJA_VIEW_CHECK_OP(view.features.depth_sigma_m.size(), ==, count);
  DEJA_VIEW_CHECK_OP(count, <=, kMaxKeypoints);
}

void WriteCamera(const Camera& camera, VirtualFrame* message) {
  const CameraParameters parameters = DescribeCamera(camera);
  message->camera_model = parameters.model;
  message->width = static_cast<std::uint32_t>(parameters.width);
  message->height = static_cast<std::uint32_t>(parameters.height);
  message->distortion = parameters.distortion;
  message->projection = parameters.projection;
}

void WriteFeatures(const VirtualFeatures& features, VirtualFrame* message) {
  message->descriptor = features.descriptor;
  for (const Keypoint& keypoint : features.features.keypoints) {
    DEJA_VIEW_CHECK(keypoint.octave >= 0 && keypoint.octave <= 255);
    message->u.push_back(keypoint.x);
    message->v.push_back(keypoint.y);
    message->response.push_back(keypoint.response);
    message->angle.push_back(keypoint.angle);
    message->octave.push_back(static_cast<std::uint8_t>(keypoint.octave));
  }
  const std::vector<Descriptor>& descriptors = features.features.descriptors;
  message->descriptors.resize(descriptors.size() * sizeof(Descriptor));
  if (!descriptors.empty()) {
    std::memcpy(message->descriptors.data(), descriptors.data(), message->descriptors.size());
  }
  message->depth = features.depth_m;
  message->depth_sigma = features.depth_sigma_m;
}

std::shared_ptr<const Camera> ReadCamera(const VirtualFrame& message, const std::string& topic) {
  const auto to_side = [](std::uint32_t side) {
    return static_cast<int>(std::min<std::uint32_t>(side, kMaxSide + 1));
  };
  auto camera = MakeCamera({message.camera_model,
                            to_side(message.width),
                            to_side(message.height),
                            message.distortion,
                            message.projection},
                           topic);
  if (std::uint64_t{message.width} * message.height > kMaxPixels) {
    ThrowInputError("{}: camera of {} x {} px: expected at most {} px",
                    topic,
                    message.width,
                    message.height,
                    kMaxPixels);
  }
  return camera;
}

void CheckIndices(const VirtualFrame& message, const std::string& topic) {
  if (message.view_index < 0 || message.view_count < 0 ||
      (message.view_count > 0 && message.view_index >= message.view_count)) {
    ThrowInputError(
        "{}: view_index {} of view_count {}: expected 0 or more, and an index below the count",
        topic,
        message.view_index,
        message.view_count);
  }
}

void ReadImages(const VirtualFrame& message, const std::string& topic, VirtualView* view) {
  const cv::Size size = SizeOf(*view->camera);
  if (!message.image.empty()) {
    if (!EnumFromString<ImageFormat>(message.image_format)) {
      ThrowInputError(
          "{}: image_format {}: expected jpeg or png", topic, Quote(message.image_format));
    }
    view->image = DecodeImage(message.image, size, CV_8UC1, topic, "image");
  }
  if (!message.depth_png.empty()) {
    view->depth_mm = DecodeImage(message.depth_png, size, CV_16UC1, topic, "depth_png");
  }
  if (!message.certainty_png.empty()) {
    view->certainty = DecodeImage(message.certainty_png, size, CV_8UC1, topic, "certainty_png");
  }
}

void CheckLengths(const VirtualFrame& message, const std::string& topic) {
  const std::size_t count = message.u.size();
  if (count > kMaxKeypoints) {
    ThrowInputError("{}: u: {} keypoints: expected at most {}", topic, count, kMaxKeypoints);
  }
  const auto check = [&](const char* field, std::size_t size, std::size_t expected) {
    if (size != expected) {
      ThrowInputError(
          "{}: {} of length {}: expected {} for {} keypoints", topic, field, size, expected, count);
    }
  };
  check("v", message.v.size(), count);
  check("response", message.response.size(), count);
  check("angle", message.angle.size(), count);
  check("octave", message.octave.size(), count);
  check("descriptors", message.descriptors.size(), count * sizeof(Descriptor));
  check("depth", message.depth.size(), count);
  check("depth_sigma", message.depth_sigma.size(), count);
}

void CheckKeypoint(const VirtualFrame& message, std::size_t i, const std::string& topic) {
  const auto fail = [&](const char* field, float value, const std::string& expected) {
    ThrowInputError("{}: {}[{}] is {}: expected {}", topic, field, i, value, expected);
  };
  const auto check_pixel = [&](const char* field, float value, std::uint32_t side) {
    if (!(value >= -0.5F && value <= static_cast<float>(side) - 0.5F)) {
      fail(field, value, fmt::format("a place in the image of {} px", side));
    }
  };
  check_pixel("u", message.u[i], message.width);
  check_pixel("v", message.v[i], message.height);
  if (!std::isfinite(message.response[i])) {
    fail("response", message.response[i], "a finite number");
  }
  if (!std::isfinite(message.angle[i])) {
    fail("angle", message.angle[i], "a finite number");
  }
  const auto check_length = [&](const char* field, float value) {
    if (!(value >= 0 && value <= std::numeric_limits<float>::max())) {
      fail(field, value, "a finite number, 0 or more");
    }
  };
  check_length("depth", message.depth[i]);
  check_length("depth_sigma", message.depth_sigma[i]);
}

VirtualFeatures ReadFeatures(const VirtualFrame& message, const std::string& topic) {
  if (!message.descriptor.empty() && message.descriptor != "brief" && message.descriptor != "orb") {
    ThrowInputError(
        "{}: descriptor {}: expected brief or orb, or nothing", topic, Quote(message.descriptor));
  }
  if (message.descriptor.empty() && !message.u.empty()) {
    ThrowInputError(
        "{}: descriptor is empty: expected brief or orb for {} keypoints", topic, message.u.size());
  }
  CheckLengths(message, topic);
  VirtualFeatures result;
  result.descriptor = message.descriptor;
  result.features.keypoints.reserve(message.u.size());
  for (std::size_t i = 0; i < message.u.size(); ++i) {
    CheckKeypoint(message, i, topic);
    result.features.keypoints.push_back(
        {message.u[i], message.v[i], message.response[i], message.angle[i], message.octave[i]});
  }
  result.features.descriptors.resize(message.u.size());
  if (!message.u.empty()) {
    // The words of a descriptor in files and messages are little endian, as every machine that ROS
    // runs on.
    std::memcpy(static_cast<void*>(result.features.descriptors.data()),
                message.descriptors.data(),
                message.descriptors.size());
  }
  result.depth_m = message.depth;
  result.depth_sigma_m = message.depth_sigma;
  return result;
}

}  // namespace

VirtualFrame ToVirtualFrame(const VirtualView& view,
                            const std::string& frame_id,
                            const VirtualFrameEncoding& encoding) {
  CheckView(view);
  VirtualFrame message;
  message.header.stamp = ToRosTime(view.stamp_ns);
  message.header.frame_id = frame_id;
  message.view_index = view.index;
  message.view_count = view.count;
  message.settings_hash = view.settings_hash;
  message.T_C_V = ToPose(view.T_C_V);
  WriteCamera(*view.camera, &message);
  if (!view.image.empty()) {
    message.image_format = EnumToString(encoding.image_format);
    message.image = encoding.image_format == ImageFormat::kPng
                        ? EncodePng(view.image)
                        : EncodeJpeg(view.image, encoding.jpeg_quality);
  }
  if (!view.depth_mm.empty()) {
    message.depth_png = EncodePng(view.depth_mm);
  }
  if (!view.certainty.empty()) {
    message.certainty_png = EncodePng(view.certainty);
  }
  WriteFeatures(view.features, &message);
  return message;
}

VirtualView FromVirtualFrame(const VirtualFrame& message,
                             const std::string& topic,
                             const std::string& sufficient_features) {
  CheckIndices(message, topic);
  VirtualView view;
  view.stamp_ns = ToNanoseconds(message.header.stamp);
  view.index = message.view_index;
  view.count = message.view_count;
  view.T_C_V = FromPose(message.T_C_V, topic);
  view.settings_hash = message.settings_hash;
  view.camera = ReadCamera(message, topic);
  if (message.image.empty() && message.descriptor.empty()) {
    ThrowInputError("{}: neither image nor features: expected one of them", topic);
  }
  if (message.descriptor.empty() || message.descriptor != sufficient_features) {
    ReadImages(message, topic, &view);
  }
  view.features = ReadFeatures(message, topic);
  return view;
}

}  // namespace deja_view
