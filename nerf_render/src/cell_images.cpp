#include "deja_view/nerf/cell_images.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include <Eigen/Geometry>

namespace deja_view::nerf {
namespace {

// The middle one of the distances that the image's points have.
double Reach(const PosedImage& image) {
  std::vector<float> ranges;
  for (const DepthPoint& point : image.points) {
    ranges.push_back(point.range);
  }
  if (ranges.empty()) {
    return std::numeric_limits<double>::infinity();
  }
  const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
  std::nth_element(ranges.begin(), middle, ranges.end());
  return static_cast<double>(*middle);
}

// Whether a ray enters the box within `reach`.
bool Enters(const Eigen::AlignedBox3d& box,
            const Eigen::Vector3d& origin,
            const Eigen::Vector3d& ray,
            double reach) {
  double near = 0;
  double far = reach;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (ray[axis] == 0) {
      if (origin[axis] < box.min()[axis] || origin[axis] > box.max()[axis]) {
        return false;
      }
      continue;
    }
    const double a = (box.min()[axis] - origin[axis]) / ray[axis];
    const double b = (box.max()[axis] - origin[axis]) / ray[axis];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near <= far;
}

// The share of the image's rays that enter the box.
double ShareInto(const Eigen::AlignedBox3d& box, const PosedImage& image) {
  constexpr int kColumns = 12;
  constexpr int kRows = 8;
  const double reach = Reach(image);
  int entering = 0;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Eigen::Vector2d pixel((column + 0.5) * image.camera->width() / kColumns - 0.5,
                                  (row + 0.5) * image.camera->height() / kRows - 0.5);
      const Eigen::Vector3d ray_N = image.T_N_C.q * image.camera->Unproject(pixel);
      entering += Enters(box, image.T_N_C.t, ray_N, reach) ? 1 : 0;
    }
  }
  return static_cast<double>(entering) / (kColumns * kRows);
}

}  // namespace

std::vector<PosedImage> SelectCellImages(const std::vector<PosedImage>& images,
                                         const SceneCell& cell,
                                         const CellImageOptions& options) {
  Eigen::AlignedBox3d all;
  Eigen::AlignedBox3d own;
  for (const PosedImage& image : images) {
    all.extend(image.T_N_C.t);
    if (cell.Contains(image.T_N_C.t)) {
      own.extend(image.T_N_C.t);
    }
  }
  std::vector<PosedImage> selected;
  if (own.isEmpty()) {
    return selected;
  }
  const Eigen::Vector3d room = Eigen::Vector3d::Constant(options.room * all.diagonal().norm());
  const Eigen::AlignedBox3d space(own.min() - room, own.max() + room);
  std::copy_if(
      images.begin(), images.end(), std::back_inserter(selected), [&](const PosedImage& image) {
        return cell.Contains(image.T_N_C.t) || space.contains(image.T_N_C.t) ||
               ShareInto(space, image) >= options.min_share;
      });
  return selected;
}

}  // namespace deja_view::nerf
