#include "super_resolution.hpp"

#include "deja_view/base/check.hpp"

#include <vector>

#include <opencv2/imgproc.hpp>

namespace deja_view::internal {

#ifdef DEJA_VIEW_HAVE_DNN

SuperResolution::SuperResolution(const std::filesystem::path& path) : path_(path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    ThrowInputError("{}: no such file: expected a network, .pb or .onnx", path.string());
  }
  try {
    network_ = cv::dnn::readNet(path.string());
  } catch (const cv::Exception& e) {
    ThrowInputError("{}: can't be read as a network, .pb or .onnx: {}", path.string(), e.what());
  }
  network_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
}

cv::Mat SuperResolution::Double(const cv::Mat& half, cv::Size size) {
  std::vector<cv::Mat> outputs;
  try {
    const std::lock_guard<std::mutex> lock(mutex_);
    network_.setInput(cv::dnn::blobFromImage(half, 1.0 / 255.0));
    cv::dnn::imagesFromBlob(network_.forward(), outputs);
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
  cv::Mat image;
  outputs[0].convertTo(image, CV_8UC1, 255.0);
  cv::Mat result;
  cv::copyMakeBorder(image,
                     result,
                     0,
                     std::max(0, size.height - image.rows),
                     0,
                     std::max(0, size.width - image.cols),
                     cv::BORDER_REPLICATE);
  return result(cv::Rect({}, size)).clone();
}

#else

SuperResolution::SuperResolution(const std::filesystem::path& path) : path_(path) {
  ThrowInputError("{}: networks need OpenCV's dnn, which this build does not have", path.string());
}

cv::Mat SuperResolution::Double(const cv::Mat& half, cv::Size /*size*/) {
  return half;
}

#endif

}  // namespace deja_view::internal
