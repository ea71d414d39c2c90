#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/nerf/training_view.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view::nerf {

/// A 16-bit image of distances; 0 and 65535: unknown.
struct DepthMapFile {
  std::filesystem::path path;            ///< empty: there is none
  double unit_m = 1e-3;                  ///< [m]
  bool is_along_ray = false;             ///< of the pixel, otherwise along the optical axis
  std::shared_ptr<const Camera> camera;  ///< at the image camera's pose; null: the image's own
};

/// An image with its camera, at the file's own size, and its pose.
struct PosedImage {
  std::filesystem::path path;  ///< for errors only where `read` is given
  std::string name;            ///< within its data set
  std::int64_t stamp_ns = 0;   ///< 0: unknown
  std::shared_ptr<const Camera> camera;
  Rigid3 T_N_C;
  std::vector<DepthPoint> points;  ///< pixels of `camera`
  DepthMapFile depth;
  /// Decodes an image that is no file of its own: CV_8UC1 or CV_8UC3 (blue, green, red). Calls may
  /// come from several threads.
  std::function<cv::Mat()> read;
};

/// How images are decoded.
struct LoadOptions {
  int channels = 1;  ///< 1: grey, 3: blue, green, red
  double scale = 1;  ///< size against the files', in (0, 1]; area means
  int max_side = 0;  ///< longest side [px], images and cameras shrink further to it; 0: any
  /// Training on a depth map: a point at every so many pixels of the file; 0: none.
  int depth_step_px = 16;
  int threads = 0;
};

/// Decodes images and shrinks them with their cameras and points. Throws InputError that names a
/// file that can't be decoded or has another size than its camera.
std::vector<TrainingView> LoadViews(const std::vector<PosedImage>& images,
                                    const LoadOptions& options);

/// 3 when one of the images, of which a few are decoded, has colours, otherwise 1: pictures that
/// are stored with three equal channels are grey.
int CountChannels(const std::vector<PosedImage>& images);

/// The camera of the image's depth map.
const std::shared_ptr<const Camera>& DepthCamera(const PosedImage& image);

/// The depth camera's pixels and the distance of what they see, CV_32FC1 of its size: [m] along
/// the unit ray, 0 where it is unknown. Throws InputError that names a file that is no 16-bit image
/// of that size.
cv::Mat ReadDepthMap(const PosedImage& image);

/// The same for the image's own pixels, wherever another camera's pixel sees nearest to them.
cv::Mat ReadImageDepth(const PosedImage& image);

/// Leaves out points that lie outside the box of the middle 98 % of all on each axis of N, widened
/// by a tenth: strays of a triangulation, which would blow up the scene's box.
void DropStrayPoints(std::vector<PosedImage>* images);

/// Who learns from which images.
struct Split {
  std::vector<PosedImage> training;
  std::vector<PosedImage> held_out;      ///< every N-th, from the first on
  std::vector<std::size_t> next;         ///< per held-out image, the training image after it
  std::vector<PosedImage> depth_checks;  ///< others with a depth map, only for the depth's error
};

/// Holds out every `every`-th image, and those with a depth map where at most half of the images
/// have one. 0: none. `next` of the last ones may be the training image before them.
Split HoldOut(const std::vector<PosedImage>& images, int every);

}  // namespace deja_view::nerf
