#pragma once

#include <vector>

#include <opencv2/core/types.hpp>

namespace deja_view::internal {

constexpr int kFastRadius = 3;  ///< [px] of the circle that FAST looks at

/// Order of corners: the stronger first, then by row and column, so that ties don't depend on the
/// input's order.
bool IsStronger(const cv::KeyPoint& a, const cv::KeyPoint& b);

/// Keeps the strongest `max_count` corners.
void KeepStrongest(std::size_t max_count, std::vector<cv::KeyPoint>* corners);

/// Keeps `max_count` corners spread over square cells of `cell_size` pixels: each cell gives its
/// strongest n, n as large as fits, and the strongest of the next ones fill up. In the order of
/// IsStronger afterwards, if there were too many.
void KeepSpread(std::size_t max_count, int cell_size, std::vector<cv::KeyPoint>* corners);

}  // namespace deja_view::internal
