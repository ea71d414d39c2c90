#include "deja_view/nerf/posed_images.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace deja_view::nerf {

namespace fs = std::filesystem;

std::vector<fs::path> ListImages(const fs::path& directory) {
  static const std::set<std::string> kExtensions = {
      ".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".bmp"};
  std::vector<fs::path> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
      return static_cast<char>(std::tolower(c));
    });
    if (kExtensions.count(extension) > 0) {
      paths.push_back(entry.path());
    }
  }
  if (error) {
    ThrowInputError("{}: can't be listed: {}", directory.string(), error.message());
  }
  if (paths.empty()) {
    ThrowInputError("{}: holds no image", directory.string());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::vector<TrainingView> LoadViews(const std::vector<PosedImage>& images,
                                    int channels,
                                    double scale,
                                    int threads) {
  DEJA_VIEW_CHECK(channels == 1 || channels == 3);
  DEJA_VIEW_CHECK(scale > 0 && scale <= 1);
  std::map<const Camera*, std::shared_ptr<const Camera>> cameras;
  for (const PosedImage& image : images) {
    auto& camera = cameras[image.camera.get()];
    if (camera == nullptr) {
      camera =
          scale < 1 ? std::shared_ptr<const Camera>(image.camera->Scaled(scale)) : image.camera;
    }
  }
  std::vector<TrainingView> views(images.size());
  ParallelFor(threads, images.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const PosedImage& from = images[i];
      const int mode = channels == 1 ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR;
      cv::Mat image = cv::imread(from.path.string(), mode | cv::IMREAD_IGNORE_ORIENTATION);
      if (image.empty()) {
        ThrowInputError("{}: can't be read as an image", from.path.string());
      }
      if (image.cols != from.camera->width() || image.rows != from.camera->height()) {
        ThrowInputError("{}: is {}x{}, its camera {}x{}",
                        from.path.string(),
                        image.cols,
                        image.rows,
                        from.camera->width(),
                        from.camera->height());
      }
      const auto& camera = cameras.at(from.camera.get());
      if (scale < 1) {
        cv::Mat small;
        cv::resize(image, small, {camera->width(), camera->height()}, 0, 0, cv::INTER_AREA);
        image = small;
      }
      views[i] = {from.name, from.stamp_ns, image, camera, from.T_N_C, {}};
    }
  });
  return views;
}

Split HoldOut(const std::vector<PosedImage>& images, int every) {
  Split split;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const bool held_out = every > 0 && i % static_cast<std::size_t>(every) == 0;
    (held_out ? split.held_out : split.training).push_back(images[i]);
  }
  return split;
}

}  // namespace deja_view::nerf
