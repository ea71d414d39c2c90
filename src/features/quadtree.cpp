#include "quadtree.hpp"

#include <algorithm>
#include <queue>

#include "select_corners.hpp"

namespace deja_view::internal {
namespace {

struct Cell {
  cv::Rect2f region;
  int depth = 0;
  std::size_t order = 0;  // of creation, to break ties
  std::vector<cv::KeyPoint> corners;
};

struct SplitsLater {
  bool operator()(const Cell& a, const Cell& b) const {
    if (a.depth != b.depth) {
      return a.depth > b.depth;
    }
    if (a.corners.size() != b.corners.size()) {
      return a.corners.size() < b.corners.size();
    }
    return a.order > b.order;
  }
};

// Corners lie on whole pixels, so that cells of less than a pixel can't part them further.
constexpr int kMaxDepth = 16;

std::vector<Cell> Split(const Cell& cell) {
  const float half_width = 0.5F * cell.region.width;
  const float half_height = 0.5F * cell.region.height;
  std::vector<Cell> quarters(4);
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 2; ++column) {
      Cell& quarter = quarters[2 * row + column];
      quarter.region = {cell.region.x + static_cast<float>(column) * half_width,
                        cell.region.y + static_cast<float>(row) * half_height,
                        half_width,
                        half_height};
      quarter.depth = cell.depth + 1;
    }
  }
  for (const cv::KeyPoint& corner : cell.corners) {
    const int column = corner.pt.x < cell.region.x + half_width ? 0 : 1;
    const int row = corner.pt.y < cell.region.y + half_height ? 0 : 1;
    quarters[2 * row + column].corners.push_back(corner);
  }
  return quarters;
}

}  // namespace

std::vector<cv::KeyPoint> SelectByQuadtree(const std::vector<cv::KeyPoint>& corners,
                                           const cv::Rect& region,
                                           std::size_t target) {
  Cell root;
  root.region = region;
  for (const cv::KeyPoint& corner : corners) {
    if (root.region.contains(corner.pt)) {
      root.corners.push_back(corner);
    }
  }
  std::vector<Cell> finished;
  std::priority_queue<Cell, std::vector<Cell>, SplitsLater> open;
  std::size_t order = 0;
  const auto add = [&](Cell cell) {
    cell.order = order++;
    if (cell.corners.size() > 1 && cell.depth < kMaxDepth) {
      open.push(std::move(cell));
    } else if (!cell.corners.empty()) {
      finished.push_back(std::move(cell));
    }
  };
  add(std::move(root));
  while (!open.empty() && open.size() + finished.size() < target) {
    const Cell cell = open.top();
    open.pop();
    for (Cell& quarter : Split(cell)) {
      add(std::move(quarter));
    }
  }
  for (; !open.empty(); open.pop()) {
    finished.push_back(open.top());
  }
  std::vector<cv::KeyPoint> kept;
  kept.reserve(finished.size());
  for (const Cell& cell : finished) {
    kept.push_back(*std::min_element(cell.corners.begin(), cell.corners.end(), IsStronger));
  }
  std::sort(kept.begin(), kept.end(), IsStronger);
  kept.resize(std::min(kept.size(), target));
  return kept;
}

}  // namespace deja_view::internal
