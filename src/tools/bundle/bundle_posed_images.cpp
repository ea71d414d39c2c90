#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"
#include "deja_view/bundle/bundle_features.hpp"
#include "deja_view/features/brief_extractor.hpp"

#include <map>

#include "bundle/bundle_command.hpp"
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

cv::Mat DecodeGrey(const nerf::PosedImage& image) {
  cv::Mat picture =
      image.read ? image.read() : cv::imread(image.path.string(), cv::IMREAD_GRAYSCALE);
  if (picture.channels() == 3) {
    cv::cvtColor(picture, picture, cv::COLOR_BGR2GRAY);
  }
  if (picture.type() != CV_8UC1 || picture.cols != image.camera->width() ||
      picture.rows != image.camera->height()) {
    ThrowInputError("{}: {} x {} px: expected a picture of 8 bits, {} x {} px as its camera's",
                    image.path.string(),
                    picture.cols,
                    picture.rows,
                    image.camera->width(),
                    image.camera->height());
  }
  return picture;
}

/// As COLMAP's model names it: the path within its folder.
std::string NameWithinFolder(const NerfInput& source, const nerf::PosedImage& image) {
  if (!source.colmap.empty() || image.path.empty()) {
    return image.name;
  }
  const std::filesystem::path folder = !source.images.empty() ? source.images
                                       : !source.seven_scenes.empty()
                                           ? source.seven_scenes
                                           : source.transforms.parent_path();
  const std::filesystem::path name = image.path.lexically_relative(folder);
  return name.empty() || *name.begin() == ".." ? image.path.filename().string() : name.string();
}

}  // namespace

BundleInput ReadPosedImages(const BundleRequest& request, const BundleToolOptions& options) {
  NerfInput source = request.input;
  source.holdout = 0;
  const std::vector<nerf::PosedImage> images = ReadNerfInput(source).training;
  BundleInput input;
  std::map<const Camera*, int> cameras;
  for (const nerf::PosedImage& image : images) {
    const auto [camera, is_new] =
        cameras.emplace(image.camera.get(), static_cast<int>(cameras.size()));
    if (is_new) {
      input.problem.cameras.push_back({image.camera, Rigid3(), 0.0});
    }
    BundleImage& bundle_image = input.problem.images.emplace_back();
    bundle_image.camera = camera->second;
    bundle_image.stamp_ns = image.stamp_ns;
    bundle_image.T_W_B = image.T_N_C;
    input.names.push_back(NameWithinFolder(source, image));
  }
  const BriefExtractor extractor(options.features);
  ParallelFor(options.bundle.threads, images.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      DescribeImage(DecodeGrey(images[i]), {}, extractor, &input.problem.images[i]);
    }
  });
  AddPosePriors(options.priors, &input.problem);
  return input;
}

}  // namespace deja_view
