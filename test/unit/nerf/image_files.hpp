#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "temporary_directory.hpp"
#include "test_cameras.hpp"
#include <opencv2/imgcodecs.hpp>

namespace deja_view::nerf {

/// A fixture with a folder for small images of 16 x 12 px.
class ImageFilesTest : public TemporaryDirectoryTest {
 protected:
  std::filesystem::path WriteImage(const std::filesystem::path& name,
                                   const cv::Mat& image = cv::Mat(12, 16, CV_8UC1, 77.0)) const {
    std::filesystem::create_directories((directory_ / name).parent_path());
    cv::imwrite((directory_ / name).string(), image);
    return directory_ / name;
  }

  static std::shared_ptr<const Camera> SmallCamera() {
    return SharedPinholeOf(16, 12, 10, 7.5, 5.5);
  }
};

}  // namespace deja_view::nerf
