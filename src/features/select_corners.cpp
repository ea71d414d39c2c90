#include "select_corners.hpp"

#include <algorithm>

namespace deja_view::internal {

bool IsStronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  if (a.response != b.response) {
    return a.response > b.response;
  }
  return a.pt.y != b.pt.y ? a.pt.y < b.pt.y : a.pt.x < b.pt.x;
}

void KeepStrongest(std::size_t max_count, std::vector<cv::KeyPoint>* corners) {
  if (corners->size() <= max_count) {
    return;
  }
  const auto last = corners->begin() + static_cast<std::ptrdiff_t>(max_count);
  std::nth_element(corners->begin(), last, corners->end(), IsStronger);
  corners->erase(last, corners->end());
  std::sort(corners->begin(), corners->end(), IsStronger);
}

void KeepSpread(std::size_t max_count, int cell_size, std::vector<cv::KeyPoint>* corners) {
  if (corners->size() <= max_count) {
    return;
  }
  std::sort(corners->begin(), corners->end(), IsStronger);
  // rank[i]: how many stronger corners the cell of corner i has; at_rank[r]: corners of rank r.
  int columns = 0;
  int rows = 0;
  for (const cv::KeyPoint& corner : *corners) {
    columns = std::max(columns, static_cast<int>(corner.pt.x) / cell_size + 1);
    rows = std::max(rows, static_cast<int>(corner.pt.y) / cell_size + 1);
  }
  std::vector<std::size_t> in_cell(static_cast<std::size_t>(columns) * rows, 0);
  std::vector<std::size_t> rank(corners->size());
  std::vector<std::size_t> at_rank;
  for (std::size_t i = 0; i < corners->size(); ++i) {
    const cv::Point2f& p = (*corners)[i].pt;
    const int cell =
        static_cast<int>(p.y) / cell_size * columns + static_cast<int>(p.x) / cell_size;
    rank[i] = in_cell[cell]++;
    at_rank.resize(std::max(at_rank.size(), rank[i] + 1), 0);
    ++at_rank[rank[i]];
  }
  std::size_t full_ranks = 0;
  std::size_t room = max_count;
  while (full_ranks < at_rank.size() && at_rank[full_ranks] <= room) {
    room -= at_rank[full_ranks++];
  }
  std::vector<cv::KeyPoint> kept;
  kept.reserve(max_count);
  for (std::size_t i = 0; i < corners->size(); ++i) {
    const bool fills_up = rank[i] == full_ranks && room > 0;
    if (rank[i] < full_ranks || fills_up) {
      kept.push_back((*corners)[i]);
      room -= fills_up ? 1 : 0;
    }
  }
  *corners = std::move(kept);
}

}  // namespace deja_view::internal
