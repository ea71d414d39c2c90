#include "super_resolution.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"
#include "deja_view/views/view_upscaling.hpp"

#include <cstring>
#include <fstream>
#include <string>

#include "synthetic_image.hpp"
#include <gmock/gmock.h>
#include <opencv2/imgproc.hpp>
#include <unistd.h>

namespace deja_view {
namespace {

#ifdef DEJA_VIEW_HAVE_DNN

// As much of protobuf's wire format as a small ONNX file needs.
std::string Varint(std::uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7U) {
    bytes += static_cast<char>(value | 0x80U);
  }
  return bytes + static_cast<char>(value);
}
std::string Number(unsigned field, std::uint64_t value) {
  return Varint(field << 3U) + Varint(value);
}
std::string Bytes(unsigned field, const std::string& bytes) {
  return Varint(field << 3U | 2U) + Varint(bytes.size()) + bytes;
}

std::string IntsAttribute(const std::string& name, const std::vector<int>& values) {
  std::string attribute = Bytes(1, name);
  for (const int value : values) {
    attribute += Number(8, static_cast<std::uint64_t>(value));
  }
  return Bytes(5, attribute + Number(20, 7));  // INTS
}

std::string TensorType(const std::string& name) {
  std::string shape;
  for (const int size : {1, 1, 30, 40}) {
    shape += Bytes(1, Number(1, static_cast<std::uint64_t>(size)));
  }
  return Bytes(1, name) + Bytes(2, Bytes(1, Number(1, 1) + Bytes(2, shape)));
}

// A transposed convolution with `kernel` x `kernel` ones and that stride: every pixel becomes a
// square.
std::string MakeNetwork(int kernel) {
  const std::vector<float> ones(static_cast<std::size_t>(kernel * kernel), 1.0F);
  std::string raw(ones.size() * sizeof(float), '\0');
  std::memcpy(raw.data(), ones.data(), raw.size());
  const auto side = static_cast<std::uint64_t>(kernel);
  const std::string weights = Number(1, 1) + Number(1, 1) + Number(1, side) + Number(1, side) +
                              Number(2, 1) + Bytes(8, "w") + Bytes(9, raw);
  const std::string node = Bytes(1, "x") + Bytes(1, "w") + Bytes(2, "y") +
                           Bytes(4, "ConvTranspose") + IntsAttribute("strides", {kernel, kernel}) +
                           IntsAttribute("kernel_shape", {kernel, kernel});
  const std::string graph = Bytes(1, node) + Bytes(2, "squares") + Bytes(5, weights) +
                            Bytes(11, TensorType("x")) + Bytes(12, TensorType("y"));
  return Number(1, 7) + Bytes(7, graph) + Bytes(8, Bytes(1, "") + Number(2, 11));
}

std::string WriteNetwork(int kernel) {
  const std::string path = ::testing::TempDir() + "deja_view_net" + std::to_string(::getpid()) +
                           "_" + std::to_string(kernel) + ".onnx";
  std::ofstream(path, std::ios::binary) << MakeNetwork(kernel);
  return path;
}

cv::Mat MakeImage(cv::Size size) {
  cv::Mat image(size, CV_8UC1);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(3 * x + 5 * y);
    }
  }
  return image;
}

TEST(SuperResolutionTest, RunsANetworkOnAnySize) {
  internal::SuperResolution network(WriteNetwork(2));
  for (const cv::Size half : {cv::Size(40, 30), cv::Size(17, 23)}) {
    const cv::Mat image = MakeImage(half);
    // One pixel more than twice the size: the last row and column are repeated.
    const cv::Size size(2 * half.width + 1, 2 * half.height);
    const cv::Mat whole = network.Double(image, size);
    ASSERT_EQ(whole.size(), size);
    ASSERT_EQ(whole.type(), CV_8UC1);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const int from = std::min(x / 2, half.width - 1);
        EXPECT_EQ(whole.at<std::uint8_t>(y, x), image.at<std::uint8_t>(y / 2, from));
      }
    }
  }
}

// What the package ships beats interpolation on a picture that it never saw.
TEST(SuperResolutionTest, ShippedNetworkIsSharperThanInterpolation) {
  internal::SuperResolution network(DEJA_VIEW_SOURCE_CONFIG "/super_resolution/fsrcnn_x2.onnx");
  for (const std::uint64_t seed : {1U, 2U}) {
    // Odd, so that the last row and column of the half are cut.
    const cv::Size size(301, 239);
    const cv::Mat whole = test::SyntheticImage(302, 240, seed);
    cv::Mat half;
    cv::resize(whole, half, {151, 120}, 0, 0, cv::INTER_AREA);
    const cv::Mat truth = whole(cv::Rect({}, size));
    const double cubic = cv::PSNR(ResizeFromHalf(half, size, cv::INTER_CUBIC), truth);
    const cv::Mat ours = network.Double(half, size);
    EXPECT_GT(cv::PSNR(ours, truth), cubic + 0.5);
    // The border, too.
    const cv::Mat rim = cv::Mat::zeros(size, CV_8UC1);
    cv::rectangle(rim, cv::Rect({}, size), 255, 6);
    EXPECT_LT(cv::norm(ours, truth, cv::NORM_L1, rim),
              cv::norm(ResizeFromHalf(half, size, cv::INTER_CUBIC), truth, cv::NORM_L1, rim));
  }
}

TEST(SuperResolutionTest, GivesTheSameInSeveralThreads) {
  internal::SuperResolution network(DEJA_VIEW_SOURCE_CONFIG "/super_resolution/fsrcnn_x2.onnx");
  const cv::Mat half = MakeImage({60, 40});
  const cv::Mat expected = network.Double(half, {120, 80});
  std::vector<cv::Mat> results(12);
  ParallelFor(4, results.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      results[i] = network.Double(half, {120, 80});
    }
  });
  for (const cv::Mat& result : results) {
    EXPECT_EQ(cv::norm(result, expected, cv::NORM_INF), 0);
  }
}

TEST(SuperResolutionTest, RefusesANetworkForAnotherFactor) {
  const std::string path = WriteNetwork(3);
  internal::SuperResolution network(path);
  try {
    network.Double(MakeImage({40, 30}), {80, 60});
    FAIL() << "no InputError";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr(path));
    EXPECT_THAT(e.what(), ::testing::HasSubstr("168 x 138 px of 56 x 46: expected twice"));
  }
}

#endif

TEST(SuperResolutionTest, NamesAFileThatIsNoNetwork) {
  try {
    internal::SuperResolution network("/nowhere/net.onnx");
    FAIL() << "no InputError";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("/nowhere/net.onnx"));
  }
}

}  // namespace
}  // namespace deja_view
