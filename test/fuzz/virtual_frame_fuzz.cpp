// Virtual views as they come from a bag or topic: bytes of a message whose lengths hold, with
// compressed images in it.
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/ros/messages/virtual_frame_conversion.hpp"

#include <memory>

#include "fuzz.hpp"
#include "message_layout.hpp"

#include <ros/message_traits.h>
#include <ros/serialization.h>

namespace deja_view::fuzz {
namespace {

constexpr int kWidth = 40;
constexpr int kHeight = 30;

VirtualView SmallView() {
  VirtualView view;
  view.stamp_ns = 1403636632538560257;
  view.count = 2;
  view.T_C_V.t = {0.1, 0, 0.2};
  view.camera = std::make_shared<PinholeCamera>(
      PinholeParameters{kWidth, kHeight, 30, 31, 20, 15, -0.1, 0.01, 1e-4, 2e-4});
  view.image = cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(77));
  view.depth_mm = cv::Mat(kHeight, kWidth, CV_16UC1, cv::Scalar(2500));
  view.certainty = cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(200));
  view.features.descriptor = "brief";
  view.features.features.keypoints = {{1, 2, 3, 0.5F, 0}, {10, 20, 3, 0.5F, 1}};
  view.features.features.descriptors.resize(2);
  view.features.depth_m = {1, 2};
  view.features.depth_sigma_m = {0.1F, 0.2F};
  return view;
}

std::string Serialized(const VirtualFrame& frame) {
  std::string bytes(ros::serialization::serializationLength(frame), '\0');
  ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()),
                                     static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, frame);
  return bytes;
}

}  // namespace

std::vector<std::string> Seeds() {
  std::vector<std::string> seeds;
  for (const ImageFormat format : {ImageFormat::kJpeg, ImageFormat::kPng}) {
    VirtualFrameEncoding encoding;
    encoding.image_format = format;
    seeds.push_back(Serialized(ToVirtualFrame(SmallView(), "cam0", encoding)));
  }
  return seeds;
}

void RunOne(const std::string& input) {
  static const internal::MessageLayout layout(ros::message_traits::datatype<VirtualFrame>(),
                                              ros::message_traits::definition<VirtualFrame>());
  std::string bytes = input;
  auto* data = reinterpret_cast<std::uint8_t*>(bytes.data());
  if (!layout.FindOverrun(data, bytes.size()).empty()) {
    return;
  }
  VirtualFrame frame;
  ros::serialization::IStream stream(data, static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::deserialize(stream, frame);
  const VirtualView view = FromVirtualFrame(frame, "/frame");
  ToVirtualFrame(view, "cam0", {});
}

}  // namespace deja_view::fuzz
