#include "deja_view/views/depth_warp_model.hpp"

#include <algorithm>
#include <utility>

namespace deja_view {
namespace {

// A depth image has edges; between tracked points there are none to be found.
constexpr int kFineMesh_px = 1;
constexpr int kCoarseMesh_px = 4;

}  // namespace

DepthWarpModel::DepthWarpModel(std::shared_ptr<const Camera> camera,
                               RangeSource ranges,
                               std::string description)
    : camera_(std::move(camera)),
      ranges_(std::move(ranges)),
      description_(std::move(description)) {}

Similarity3 DepthWarpModel::FindFrame(const std::optional<Similarity3>& /*told*/) const {
  return {};
}

std::shared_ptr<const ViewRenderer> DepthWarpModel::RendererFor(
    const ViewSource& source, const std::vector<RangeSample>& points) const {
  std::optional<RangeMap> known = ranges_ ? ranges_(source.stamp_ns) : std::nullopt;
  const int mesh_px = known ? kFineMesh_px : kCoarseMesh_px;
  return std::make_shared<DepthWarpRenderer>(
      source.image,
      known ? std::move(*known) : DensifyRanges(points, source.image.size()),
      camera_,
      source.T_N_C,
      mesh_px);
}

bool DepthWarpModel::NeedsPoints() const {
  return !ranges_;
}

void DepthWarpModel::Relax(GateOptions* gate) const {
  // An image does not show what is beside it: only its own path could be called free.
  gate->free_space = false;
  // Its ranges are guessed between few points: what is asked of a field would leave hardly a view.
  gate->max_depth_sigma = std::max(0.3, gate->max_depth_sigma);
  gate->min_certain_share = std::min(0.5, gate->min_certain_share);
}

std::string DepthWarpModel::Describe() const {
  return description_;
}

}  // namespace deja_view
