#include "super_resolution.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"
#include "deja_view/base/quote.hpp"

#include <algorithm>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace deja_view::internal {

#ifdef DEJA_VIEW_HAVE_DNN

namespace {

// Pixels by which an image is continued: a convolution takes what is beyond for black.
constexpr int kRim = 8;

cv::dnn::Net ReadNetwork(const std::filesystem::path& path) {
  CheckInputFile(path);
  cv::dnn::Net network;
  try {
    network = cv::dnn::readNet(path.string());
  } catch (const cv::Exception& e) {
    ThrowInputError(
        "{}: can't be read as a network, .pb or .onnx: {}", path.string(), Quote(e.err, 200));
  }
  network.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
  return network;
}

}  // namespace

SuperResolution::SuperResolution(const std::filesystem::path& path)
    : path_(path), idle_{ReadNetwork(path)} {}

cv::dnn::Net SuperResolution::Borrow() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!idle_.empty()) {
      cv::dnn::Net network = idle_.back();
      idle_.pop_back();
      return network;
    }
  }
  return ReadNetwork(path_);
}

void SuperResolution::GiveBack(const cv::dnn::Net& network) {
  const std::lock_guard<std::mutex> lock(mutex_);
  idle_.push_back(network);
}

cv::Mat SuperResolution::Double(const cv::Mat& image, cv::Size size) {
  cv::Mat half;
  cv::copyMakeBorder(image, half, kRim, kRim, kRim, kRim, cv::BORDER_REPLICATE);
  std::vector<cv::Mat> outputs;
  try {
    cv::dnn::Net network = Borrow();
    network.setInput(cv::dnn::blobFromImage(half, 1.0 / 255.0));
    cv::dnn::imagesFromBlob(network.forward(), outputs);
    GiveBack(network);
  } catch (const cv::Exception& e) {
    ThrowInputError("{}: the network fails on an image of {} x {} px: {}",
                    path_.string(),
                    half.cols,
                    half.rows,
                    e.what());
  }
  if (outputs.size() != 1 || outputs[0].channels() != 1 || outputs[0].cols != 2 * half.cols ||
      outputs[0].rows != 2 * half.rows) {
    ThrowInputError("{}: the network makes {} x {} px of {} x {}: expected twice the size",
                    path_.string(),
                    outputs.empty() ? 0 : outputs[0].cols,
                    outputs.empty() ? 0 : outputs[0].rows,
                    half.cols,
                    half.rows);
  }
  const cv::Size doubled(2 * image.cols, 2 * image.rows);
  cv::Mat grey;
  outputs[0](cv::Rect({2 * kRim, 2 * kRim}, doubled)).convertTo(grey, CV_8UC1, 255.0);
  cv::Mat result;
  cv::copyMakeBorder(grey,
                     result,
                     0,
                     std::max(0, size.height - grey.rows),
                     0,
                     std::max(0, size.width - grey.cols),
                     cv::BORDER_REPLICATE);
  return result(cv::Rect({}, size)).clone();
}

#else

SuperResolution::SuperResolution(const std::filesystem::path& path) : path_(path) {
  ThrowInputError("{}: networks need OpenCV's dnn, which this build does not have", path.string());
}

cv::Mat SuperResolution::Double(const cv::Mat& image, cv::Size /*size*/) {
  return image;
}

#endif

}  // namespace deja_view::internal
