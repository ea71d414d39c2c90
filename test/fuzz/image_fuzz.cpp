// Compressed images of virtual views: PNG and JPEG, grey of 8 bits, and of 16 after a first byte of
// 1.
#include "deja_view/io/encoded_image.hpp"

#include "fuzz.hpp"
#include <opencv2/core.hpp>

namespace deja_view::fuzz {
namespace {

const cv::Size kSize(40, 30);

std::string Text(const std::vector<std::uint8_t>& bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

std::vector<std::string> Seeds() {
  cv::Mat grey(kSize, CV_8UC1);
  cv::Mat depth(kSize, CV_16UC1);
  for (int i = 0; i < kSize.area(); ++i) {
    grey.at<std::uint8_t>(i / kSize.width, i % kSize.width) = static_cast<std::uint8_t>(7 * i);
    depth.at<std::uint16_t>(i / kSize.width, i % kSize.width) = static_cast<std::uint16_t>(77 * i);
  }
  return {'\0' + Text(EncodePng(grey)),
          '\0' + Text(EncodeJpeg(grey, 70)),
          '\1' + Text(EncodePng(depth))};
}

void RunOne(const std::string& input) {
  const auto [prefix, bytes] = SplitPrefix(input);
  const std::vector<std::uint8_t> data(bytes.begin(), bytes.end());
  EncodedSize(data);
  DecodeImage(data, kSize, prefix == 1 ? CV_16UC1 : CV_8UC1, "/frame", "image");
}

}  // namespace deja_view::fuzz
