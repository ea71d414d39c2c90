#include "deja_view/nerf/scene_cells.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace deja_view::nerf {
namespace {

using PositionList = std::vector<Eigen::Vector3d>;

struct Cut {
  Eigen::Index axis = 0;
  double at = 0;  // what is less lies on the one side, all else on the other
};

// The place between two cameras that leaves as near to `share` of them as can be below it; they are
// not all at one place of this axis.
double CutAlong(const PositionList& positions, Eigen::Index axis, double share) {
  std::vector<double> x;
  for (const Eigen::Vector3d& p : positions) {
    x.push_back(p[axis]);
  }
  std::sort(x.begin(), x.end());
  const auto wanted = std::llround(share * static_cast<double>(x.size()));
  std::size_t best = 0;
  for (std::size_t i = 1; i < x.size(); ++i) {
    const auto off = [&](std::size_t at) { return std::abs(static_cast<long long>(at) - wanted); };
    if (x[i - 1] < x[i] && (best == 0 || off(i) < off(best))) {
      best = i;
    }
  }
  const double middle = x[best - 1] + 0.5 * (x[best] - x[best - 1]);
  return middle > x[best - 1] ? middle : x[best];
}

// Across the widest axis; the positions are not all the same.
Cut FindCut(const PositionList& positions, double share) {
  Eigen::Vector3d low = positions.front();
  Eigen::Vector3d high = positions.front();
  for (const Eigen::Vector3d& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Cut cut;
  (high - low).maxCoeff(&cut.axis);
  cut.at = CutAlong(positions, cut.axis, share);
  return cut;
}

int CountPlaces(PositionList positions) {
  const auto is_before = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::sort(positions.begin(), positions.end(), is_before);
  return static_cast<int>(std::unique(positions.begin(), positions.end()) - positions.begin());
}

// Needs as many places as cells.
void CutCell(const PositionList& positions,
             const SceneCell& cell,
             int count,
             std::vector<SceneCell>* cells) {
  if (count == 1) {
    cells->push_back(cell);
    return;
  }
  const Cut cut = FindCut(positions, static_cast<double>(count / 2) / count);
  PositionList below;
  PositionList above;
  for (const Eigen::Vector3d& p : positions) {
    (p[cut.axis] < cut.at ? below : above).push_back(p);
  }
  SceneCell below_cell = cell;
  SceneCell above_cell = cell;
  below_cell.max[cut.axis] = cut.at;
  above_cell.min[cut.axis] = cut.at;
  // Half of the cells, unless there are too few places for them on one side.
  const int below_count =
      std::min(std::max(count / 2, count - CountPlaces(above)), CountPlaces(below));
  CutCell(below, below_cell, below_count, cells);
  CutCell(above, above_cell, count - below_count, cells);
}

}  // namespace

std::vector<SceneCell> CutByCameras(const std::vector<Eigen::Vector3d>& positions_N, int count) {
  DEJA_VIEW_CHECK(count >= 1);
  if (!std::all_of(positions_N.begin(), positions_N.end(), [](const Eigen::Vector3d& p) {
        return p.allFinite();
      })) {
    ThrowInputError("sub-maps: a camera's position is not finite");
  }
  const int places = CountPlaces(positions_N);
  if (places < count) {
    ThrowInputError(
        "sub-maps: the cameras stand at {} places, too few for {} cells", places, count);
  }
  std::vector<SceneCell> cells;
  CutCell(positions_N, SceneCell(), count, &cells);
  return cells;
}

}  // namespace deja_view::nerf
