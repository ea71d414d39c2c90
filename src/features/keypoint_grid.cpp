#include "deja_view/features/keypoint_grid.hpp"

#include <algorithm>

namespace deja_view {

KeypointGrid::KeypointGrid(const std::vector<Eigen::Vector2f>& keypoints,
                           int width,
                           int height,
                           float cell_px)
    : keypoints_(keypoints),
      cell_px_(cell_px),
      columns_(static_cast<int>(static_cast<float>(width) / cell_px) + 1),
      rows_(static_cast<int>(static_cast<float>(height) / cell_px) + 1),
      begin_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0),
      order_(keypoints.size()) {
  std::vector<std::size_t> cells(keypoints.size());
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    cells[i] = Cell(Column(keypoints[i].x()), Row(keypoints[i].y()));
    ++begin_[cells[i] + 1];
  }
  for (std::size_t c = 1; c < begin_.size(); ++c) {
    begin_[c] += begin_[c - 1];
  }
  std::vector<int> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    order_[static_cast<std::size_t>(next[cells[i]]++)] = static_cast<int>(i);
  }
}

int KeypointGrid::Column(float x) const {
  return std::clamp(static_cast<int>(x / cell_px_), 0, columns_ - 1);
}

int KeypointGrid::Row(float y) const {
  return std::clamp(static_cast<int>(y / cell_px_), 0, rows_ - 1);
}

}  // namespace deja_view
