#include "deja_view/nerf/scene_box.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace deja_view::nerf {
namespace {

constexpr double kOutlierShare = 2e-3;  ///< of the depth points, at either end of an axis

}  // namespace

SceneBox BoxAround(const std::vector<TrainingView>& views, double margin) {
  SceneBox box;
  box.min.setConstant(std::numeric_limits<double>::max());
  box.max.setConstant(std::numeric_limits<double>::lowest());
  std::array<std::vector<double>, 3> points;
  for (const TrainingView& view : views) {
    box.min = box.min.cwiseMin(view.T_N_C.t);
    box.max = box.max.cwiseMax(view.T_N_C.t);
    for (const DepthPoint& point : view.points) {
      const Eigen::Vector3d p_N = view.T_N_C * (static_cast<double>(point.range) *
                                                view.camera->Unproject({point.u, point.v}));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        points[axis].push_back(p_N[static_cast<Eigen::Index>(axis)]);
      }
    }
  }
  for (std::size_t axis = 0; axis < 3 && !points[axis].empty(); ++axis) {
    std::vector<double>& values = points[axis];
    const auto i = static_cast<Eigen::Index>(axis);
    const auto outliers = static_cast<std::ptrdiff_t>(
        std::min(std::ceil(kOutlierShare * static_cast<double>(values.size())),
                 0.1 * static_cast<double>(values.size())));
    const auto low = values.begin() + outliers;
    const auto high = values.end() - 1 - outliers;
    std::nth_element(values.begin(), low, values.end());
    box.min[i] = std::min(box.min[i], *low);
    std::nth_element(values.begin(), high, values.end());
    box.max[i] = std::max(box.max[i], *high);
  }
  const double diagonal = views.empty() ? 0 : (box.max - box.min).norm();
  if (!(diagonal > 1e-6) || !std::isfinite(diagonal)) {
    ThrowInputError("training: the {} camera poses are all in one place", views.size());
  }
  const Eigen::Vector3d grow = Eigen::Vector3d::Constant(margin * diagonal);
  box.min -= grow;
  box.max += grow;
  return box;
}

}  // namespace deja_view::nerf
