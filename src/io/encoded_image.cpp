#include "deja_view/io/encoded_image.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include <opencv2/imgcodecs.hpp>

namespace deja_view {
namespace {

constexpr std::array<std::uint8_t, 8> kPngSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};

int BigEndian(const std::vector<std::uint8_t>& data, std::size_t at, std::size_t bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    value = value << 8U | data[at + i];
  }
  // No image that we read has sides that long; larger ones must not wrap around.
  return static_cast<int>(std::min(value, 0x7FFFFFFFU));
}

cv::Size PngSize(const std::vector<std::uint8_t>& data) {
  // Signature, length and type of the IHDR chunk, width, height.
  return data.size() < 24 ? cv::Size() : cv::Size(BigEndian(data, 16, 4), BigEndian(data, 20, 4));
}

// Markers that start a frame, which states the size: SOF0 to SOF15 but for DHT, JPG and DAC.
bool IsStartOfFrame(std::uint8_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

cv::Size JpegSize(const std::vector<std::uint8_t>& data) {
  std::size_t at = 2;
  while (at + 9 <= data.size() && data[at] == 0xFF) {
    const std::uint8_t marker = data[at + 1];
    if (marker == 0xFF) {  // a fill byte
      ++at;
      continue;
    }
    if (IsStartOfFrame(marker)) {
      return {BigEndian(data, at + 7, 2), BigEndian(data, at + 5, 2)};
    }
    at += 2 + static_cast<std::size_t>(BigEndian(data, at + 2, 2));
  }
  return {};
}

std::vector<std::uint8_t> Encode(const char* extension,
                                 const cv::Mat& image,
                                 const std::vector<int>& parameters) {
  std::vector<std::uint8_t> data;
  DEJA_VIEW_CHECK(cv::imencode(extension, image, data, parameters));
  return data;
}

}  // namespace

cv::Size EncodedSize(const std::vector<std::uint8_t>& data) {
  if (data.size() > kPngSignature.size() &&
      std::equal(kPngSignature.begin(), kPngSignature.end(), data.begin())) {
    return PngSize(data);
  }
  if (data.size() > 2 && data[0] == 0xFF && data[1] == 0xD8) {
    return JpegSize(data);
  }
  return {};
}

cv::Mat DecodeImage(const std::vector<std::uint8_t>& data,
                    cv::Size size,
                    int type,
                    const std::string& topic,
                    const char* field) {
  const cv::Size encoded = EncodedSize(data);
  if (encoded != size) {
    ThrowInputError("{}: {}: {} bytes of an image of {} x {} px: expected PNG or JPEG of {} x {}",
                    topic,
                    field,
                    data.size(),
                    encoded.width,
                    encoded.height,
                    size.width,
                    size.height);
  }
  cv::Mat image;
  try {
    image = cv::imdecode(
        data, cv::IMREAD_ANYDEPTH | cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.size() != size || image.type() != type) {
    ThrowInputError("{}: {}: {} bytes that can't be decoded: expected a grey image of {} bits",
                    topic,
                    field,
                    data.size(),
                    CV_ELEM_SIZE(type) * 8);
  }
  return image;
}

std::vector<std::uint8_t> EncodeJpeg(const cv::Mat& image, int quality) {
  return Encode(".jpg", image, {cv::IMWRITE_JPEG_QUALITY, quality, cv::IMWRITE_JPEG_OPTIMIZE, 1});
}

std::vector<std::uint8_t> EncodePng(const cv::Mat& image) {
  return Encode(".png", image, {cv::IMWRITE_PNG_COMPRESSION, 3});
}

}  // namespace deja_view
