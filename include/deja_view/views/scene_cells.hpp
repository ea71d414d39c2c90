#pragma once

#include "deja_view/base/shard.hpp"

#include <limits>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// A box of space, min <= p < max on each axis [m]; without end where nothing lies beyond.
struct SceneCell {
  Eigen::Vector3d min = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());
  Eigen::Vector3d max = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());

  bool Contains(const Eigen::Vector3d& p) const {
    return (p.array() >= min.array()).all() && (p.array() < max.array()).all();
  }
  bool operator==(const SceneCell& o) const { return min == o.min && max == o.max; }

  template <typename Visitor>
  void Visit(Visitor& v) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      v("min", min[axis]);
      v("max", max[axis]);
    }
  }
};

/// A scene that is cut into sub-maps with a model each: every place is in exactly one cell, and a
/// model is there for cameras in its own.
struct SceneCells {
  int index = 0;                 ///< whose cell is the model's own
  std::vector<SceneCell> cells;  ///< in N; empty: the scene is not cut

  bool IsCut() const { return !cells.empty(); }
  /// Of a scene that is cut.
  const SceneCell& own() const { return cells[static_cast<std::size_t>(index)]; }
  Shard shard() const { return {index, IsCut() ? static_cast<int>(cells.size()) : 1}; }
  /// Whether a camera at p_N is the model's own.
  bool IsOwn(const Eigen::Vector3d& p_N) const { return !IsCut() || own().Contains(p_N); }
};

}  // namespace deja_view
