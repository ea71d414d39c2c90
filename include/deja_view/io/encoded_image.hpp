#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view {

/// Size that the header of a PNG or JPEG file states; (0, 0) when it is neither or is cut off.
cv::Size EncodedSize(const std::vector<std::uint8_t>& data);

/// Decodes a PNG or JPEG of one channel, of the type CV_8UC1 or CV_16UC1. Throws InputError that
/// names topic and field for another size, type or format; the size is checked before decoding.
cv::Mat DecodeImage(const std::vector<std::uint8_t>& data,
                    cv::Size size,
                    int type,
                    const std::string& topic,
                    const char* field);

/// JPEG of the given quality, from 1 to 100.
std::vector<std::uint8_t> EncodeJpeg(const cv::Mat& image, int quality);

/// PNG; quick rather than small.
std::vector<std::uint8_t> EncodePng(const cv::Mat& image);

}  // namespace deja_view
