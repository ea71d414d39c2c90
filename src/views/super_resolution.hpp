#pragma once

#include <filesystem>
#include <mutex>
#include <vector>

#include <opencv2/core/mat.hpp>
#ifdef DEJA_VIEW_HAVE_DNN
#include <opencv2/dnn/dnn.hpp>
#endif

namespace deja_view::internal {

/// A network that doubles grey images, e.g. FSRCNN_x2.pb of OpenCV's dnn_superres: one channel of
/// values from 0 to 1, in and out. Safe to use from several threads.
class SuperResolution {
 public:
  /// Throws InputError that names the file when it can't be read as a network, and where OpenCV has
  /// no dnn.
  explicit SuperResolution(const std::filesystem::path& path);

  /// CV_8UC1 of `size`, cut or continued by a pixel where that is odd. Throws InputError that names
  /// the file when the network's output is not twice the input's size.
  cv::Mat Double(const cv::Mat& image, cv::Size size);

 private:
  std::filesystem::path path_;
#ifdef DEJA_VIEW_HAVE_DNN
  cv::dnn::Net Borrow();
  void GiveBack(const cv::dnn::Net& network);

  std::mutex mutex_;
  std::vector<cv::dnn::Net> idle_;  // a network holds the state of its run: one per thread
#endif
};

}  // namespace deja_view::internal
