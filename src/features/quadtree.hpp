#pragma once

#include <cstddef>
#include <vector>

#include <opencv2/core/types.hpp>

namespace deja_view::internal {

/// Splits `region` in four again and again, the largest cells first and of these the fullest, until
/// `target` cells hold corners or no cell holds two; keeps the strongest corner of each cell
/// (IsStronger), at most `target`. Corners outside the region are left out. In the order of
/// IsStronger.
std::vector<cv::KeyPoint> SelectByQuadtree(const std::vector<cv::KeyPoint>& corners,
                                           const cv::Rect& region,
                                           std::size_t target);

}  // namespace deja_view::internal
