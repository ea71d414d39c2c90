#include "deja_view/nerf/posed_images.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <Eigen/Geometry>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace deja_view::nerf {
namespace {

cv::Mat ReadFile(const PosedImage& image, int channels) {
  const int mode = channels == 1 ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR;
  cv::Mat pixels = cv::imread(image.path.string(), mode | cv::IMREAD_IGNORE_ORIENTATION);
  if (pixels.empty()) {
    ThrowInputError("{}: can't be read as an image", image.path.string());
  }
  return pixels;
}

cv::Mat Decode(const PosedImage& image, int channels) {
  cv::Mat pixels = image.read ? image.read() : ReadFile(image, channels);
  if (pixels.channels() != channels) {
    cv::Mat converted;
    cv::cvtColor(pixels, converted, channels == 1 ? cv::COLOR_BGR2GRAY : cv::COLOR_GRAY2BGR);
    pixels = converted;
  }
  if (pixels.cols != image.camera->width() || pixels.rows != image.camera->height()) {
    ThrowInputError("{}: is {}x{}, its camera {}x{}",
                    image.path.string(),
                    pixels.cols,
                    pixels.rows,
                    image.camera->width(),
                    image.camera->height());
  }
  return pixels;
}

double ScaleOf(const Camera& camera, const LoadOptions& options) {
  const double longest = std::max(camera.width(), camera.height());
  return options.max_side > 0 ? std::min(options.scale, options.max_side / longest) : options.scale;
}

// Points of the image itself and of its depth map's grid, as pixels of the smaller camera.
std::vector<DepthPoint> ScaledPoints(const PosedImage& image,
                                     double scale,
                                     const LoadOptions& options) {
  std::vector<DepthPoint> points = image.points;
  if (!image.depth.path.empty() && options.depth_step_px > 0) {
    const cv::Mat depth = ReadDepthMap(image);
    const Camera& depth_camera = *DepthCamera(image);
    const int step = options.depth_step_px;
    for (int y = step / 2; y < depth.rows; y += step) {
      for (int x = step / 2; x < depth.cols; x += step) {
        const float range = depth.at<float>(y, x);
        if (!(range > 0)) {
          continue;
        }
        // As it is, to the last bit, where one camera saw both.
        std::optional<Eigen::Vector2d> pixel(std::in_place, x, y);
        if (image.depth.camera) {
          pixel = image.camera->Project(depth_camera.Unproject({x, y}));
        }
        if (pixel && image.camera->IsInImage(*pixel)) {
          points.push_back({static_cast<float>(pixel->x()), static_cast<float>(pixel->y()), range});
        }
      }
    }
  }
  for (DepthPoint& point : points) {
    point.u = static_cast<float>((point.u + 0.5) * scale - 0.5);
    point.v = static_cast<float>((point.v + 0.5) * scale - 0.5);
  }
  return points;
}

bool HasColors(const PosedImage& image) {
  const cv::Mat pixels =
      image.read
          ? image.read()
          : cv::imread(image.path.string(), cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION);
  if (pixels.empty()) {
    ThrowInputError("{}: can't be read as an image", image.path.string());
  }
  if (pixels.channels() != 3) {
    return false;
  }
  // A grey picture that went through JPEG as colours differs by its rounding.
  constexpr double kLargestRounding = 1;
  std::array<cv::Mat, 3> planes;
  cv::split(pixels, planes.data());
  const double pixel_count = static_cast<double>(pixels.total());
  return cv::norm(planes[0], planes[1], cv::NORM_L1) / pixel_count > kLargestRounding ||
         cv::norm(planes[1], planes[2], cv::NORM_L1) / pixel_count > kLargestRounding;
}

Eigen::Vector3d Position(const PosedImage& image, const DepthPoint& point) {
  return image.T_N_C *
         (static_cast<double>(point.range) * image.camera->Unproject({point.u, point.v}));
}

double Quantile(std::vector<double>* values, double share) {
  const auto at = values->begin() + std::lround(share * static_cast<double>(values->size() - 1));
  std::nth_element(values->begin(), at, values->end());
  return *at;
}

}  // namespace

std::vector<TrainingView> LoadViews(const std::vector<PosedImage>& images,
                                    const LoadOptions& options) {
  DEJA_VIEW_CHECK(options.channels == 1 || options.channels == 3);
  DEJA_VIEW_CHECK(options.scale > 0 && options.scale <= 1);
  std::map<const Camera*, std::shared_ptr<const Camera>> cameras;
  for (const PosedImage& image : images) {
    auto& camera = cameras[image.camera.get()];
    const double scale = ScaleOf(*image.camera, options);
    if (camera == nullptr) {
      camera =
          scale < 1 ? std::shared_ptr<const Camera>(image.camera->Scaled(scale)) : image.camera;
    }
  }
  std::vector<TrainingView> views(images.size());
  ParallelFor(options.threads, images.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const PosedImage& from = images[i];
      cv::Mat pixels = Decode(from, options.channels);
      const double scale = ScaleOf(*from.camera, options);
      const auto& camera = cameras.at(from.camera.get());
      if (scale < 1) {
        cv::Mat small;
        cv::resize(pixels, small, {camera->width(), camera->height()}, 0, 0, cv::INTER_AREA);
        pixels = small;
      }
      views[i] = {
          from.name, from.stamp_ns, pixels, camera, from.T_N_C, ScaledPoints(from, scale, options)};
    }
  });
  return views;
}

int CountChannels(const std::vector<PosedImage>& images) {
  constexpr std::size_t kLooks = 3;
  for (std::size_t look = 0; look < std::min(kLooks, images.size()); ++look) {
    if (HasColors(images[look * (images.size() - 1) / (kLooks - 1)])) {
      return 3;
    }
  }
  return 1;
}

const std::shared_ptr<const Camera>& DepthCamera(const PosedImage& image) {
  return image.depth.camera ? image.depth.camera : image.camera;
}

cv::Mat ReadDepthMap(const PosedImage& image) {
  const Camera& camera = *DepthCamera(image);
  const cv::Mat stored = cv::imread(image.depth.path.string(), cv::IMREAD_UNCHANGED);
  if (stored.type() != CV_16UC1 || stored.cols != camera.width() ||
      stored.rows != camera.height()) {
    ThrowInputError("{}: expected a 16-bit grey image of {}x{}, the size of its camera",
                    image.depth.path.string(),
                    camera.width(),
                    camera.height());
  }
  constexpr std::uint16_t kUnknown = 65535;
  cv::Mat range = cv::Mat::zeros(stored.size(), CV_32FC1);
  for (int y = 0; y < stored.rows; ++y) {
    for (int x = 0; x < stored.cols; ++x) {
      const auto depth = stored.at<std::uint16_t>(y, x);
      const double share = image.depth.is_along_ray ? 1 : camera.Unproject({x, y}).z();
      if (depth > 0 && depth < kUnknown && share > 0) {
        range.at<float>(y, x) = static_cast<float>(depth * image.depth.unit_m / share);
      }
    }
  }
  return range;
}

cv::Mat ReadImageDepth(const PosedImage& image) {
  cv::Mat depth = ReadDepthMap(image);
  if (!image.depth.camera) {
    return depth;
  }
  cv::Mat range = cv::Mat::zeros(image.camera->height(), image.camera->width(), CV_32FC1);
  for (int y = 0; y < range.rows; ++y) {
    for (int x = 0; x < range.cols; ++x) {
      const Eigen::Vector3d ray = image.camera->Unproject({x, y});
      const auto pixel = image.depth.camera->Project(ray);
      if (!pixel) {
        continue;
      }
      const cv::Point at(cvRound(pixel->x()), cvRound(pixel->y()));
      if (cv::Rect(0, 0, depth.cols, depth.rows).contains(at)) {
        // Of the same distance along the axis, as the two rays differ a little.
        const double share = image.depth.camera->Unproject({at.x, at.y}).z() / ray.z();
        range.at<float>(y, x) = static_cast<float>(share) * depth.at<float>(at);
      }
    }
  }
  return range;
}

void DropStrayPoints(std::vector<PosedImage>* images) {
  std::array<std::vector<double>, 3> coordinates;
  for (const PosedImage& image : *images) {
    for (const DepthPoint& point : image.points) {
      const Eigen::Vector3d p_N = Position(image, point);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        coordinates[axis].push_back(p_N[static_cast<Eigen::Index>(axis)]);
      }
    }
  }
  if (coordinates[0].empty()) {
    return;
  }
  Eigen::AlignedBox3d box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = Quantile(&coordinates[axis], 0.01);
    const double high = Quantile(&coordinates[axis], 0.99);
    const double room = 0.1 * (high - low);
    box.min()[static_cast<Eigen::Index>(axis)] = low - room;
    box.max()[static_cast<Eigen::Index>(axis)] = high + room;
  }
  for (PosedImage& image : *images) {
    auto& points = image.points;
    const auto is_stray = [&](const DepthPoint& p) { return !box.contains(Position(image, p)); };
    points.erase(std::remove_if(points.begin(), points.end(), is_stray), points.end());
  }
}

Split HoldOut(const std::vector<PosedImage>& images, int every) {
  const auto has_depth = [](const PosedImage& image) { return !image.depth.path.empty(); };
  const auto with_depth =
      static_cast<std::size_t>(std::count_if(images.begin(), images.end(), has_depth));
  const bool depth_is_rare = 2 * with_depth <= images.size();
  Split split;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (every > 0 && i % static_cast<std::size_t>(every) == 0) {
      split.held_out.push_back(images[i]);
      split.next.push_back(split.training.size());
    } else if (every > 0 && depth_is_rare && has_depth(images[i])) {
      split.depth_checks.push_back(images[i]);
    } else {
      split.training.push_back(images[i]);
    }
  }
  const std::size_t last = std::max<std::size_t>(split.training.size(), 1) - 1;
  for (std::size_t& next : split.next) {
    next = std::min(next, last);
  }
  return split;
}

}  // namespace deja_view::nerf
