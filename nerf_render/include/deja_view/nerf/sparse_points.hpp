#pragma once

#include "deja_view/nerf/training_view.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace deja_view::nerf {

/// How points are found that several posed images share.
struct SparsePointOptions {
  int features = 800;              ///< corners per image, BRIEF
  int neighbours = 6;              ///< images that each image is matched with
  double max_angle_deg = 35;       ///< between the viewing directions of a pair
  int max_distance = 60;           ///< [bit] between matched descriptors
  double max_error_px = 1.5;       ///< from the epipolar line, at the images' size
  double min_parallax_deg = 1;     ///< of a pair of rays that gives a point
  double max_disagreement = 0.05;  ///< of the ranges that two pairs give, as a share
  double max_sigma = 0.03;         ///< standard deviation of a range, as a share of it
  int min_pairs = 2;               ///< that agree on a point

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("features", features);
    v("neighbours", neighbours);
    v("max_angle_deg", max_angle_deg);
    v("max_distance", max_distance);
    v("max_error_px", max_error_px);
    v("min_parallax_deg", min_parallax_deg);
    v("max_disagreement", max_disagreement);
    v("max_sigma", max_sigma);
    v("min_pairs", min_pairs);
  }
};

/// Adds to `views[i].points` the corners of image i that are found again in other images, with the
/// ranges that the given poses make of them; so a field can be told where the surfaces are before
/// it has learnt any. Images are matched in their grey levels. Returns the number of points added;
/// the same for any number of threads.
std::size_t AddSparsePoints(const SparsePointOptions& options,
                            int threads,
                            std::vector<TrainingView>* views);

}  // namespace deja_view::nerf
