#pragma once

#include <vector>

#include "loss_of_ray.hpp"
#include "ray_tracer.hpp"

namespace deja_view::nerf::internal {

/// Losses of a batch of rays and their derivatives.
struct LossGradient {
  std::vector<float> d_raw;         ///< per sample: d loss / d log density
  std::vector<float> d_color_rows;  ///< n x color.output_stride(): d loss / d (before the sigmoid)
  std::vector<float> d_background_rows;  ///< per ray, as d_color_rows; empty without background
  std::vector<GainBias> d_exposure;      ///< per ray
  double loss = 0;                       ///< sum over rays
  double squared_error = 0;              ///< sum over the colour rays' channels
  std::size_t color_values = 0;          ///< terms of squared_error
};

/// RayLoss of every ray.
void ComputeLoss(const RadianceField& field,
                 const Trace& trace,
                 const std::vector<RayTarget>& targets,
                 const std::vector<GainBias>& exposures,
                 const LossOptions& options,
                 LossGradient* gradient);

}  // namespace deja_view::nerf::internal
