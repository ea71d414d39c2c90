#pragma once

#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// Keypoints sorted into square cells, to find those near a pixel. Refers to the keypoints it was
/// built on.
class KeypointGrid {
 public:
  KeypointGrid(const std::vector<Eigen::Vector2f>& keypoints, int width, int height, float cell_px);

  /// Calls `visit(index)` for every keypoint within `radius_px` of `pixel`, in an order fixed by
  /// the grid.
  template <typename Visitor>
  void ForEachNear(const Eigen::Vector2f& pixel, float radius_px, Visitor&& visit) const {
    const int x0 = Column(pixel.x() - radius_px);
    const int x1 = Column(pixel.x() + radius_px);
    const int y0 = Row(pixel.y() - radius_px);
    const int y1 = Row(pixel.y() + radius_px);
    const float squared = radius_px * radius_px;
    for (int y = y0; y <= y1; ++y) {
      for (int i = begin_[Cell(x0, y)]; i < begin_[Cell(x1, y) + 1]; ++i) {
        const int index = order_[static_cast<std::size_t>(i)];
        if ((keypoints_[static_cast<std::size_t>(index)] - pixel).squaredNorm() <= squared) {
          visit(index);
        }
      }
    }
  }

 private:
  int Column(float x) const;
  int Row(float y) const;
  std::size_t Cell(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }

  const std::vector<Eigen::Vector2f>& keypoints_;
  float cell_px_;
  int columns_;
  int rows_;
  std::vector<int> begin_;  ///< first entry of each cell in order_, and one past the end
  std::vector<int> order_;
};

}  // namespace deja_view
