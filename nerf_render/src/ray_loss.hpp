#pragma once

#include "deja_view/nerf/options.hpp"

#include <array>
#include <vector>

#include "ray_tracer.hpp"

namespace deja_view::nerf::internal {

/// What one training ray should show.
struct RayTarget {
  std::uint32_t view = 0;
  std::array<float, 3> color = {};  ///< [white]
  float range = 0;                  ///< of a depth point, in unit lengths; 0: unknown
  float off_axis = 0;               ///< 1 - z of the camera's unit ray
  float vignetting = 1;             ///< there
};

/// Weights of the losses, from TrainOptions.
struct LossOptions {
  float huber_delta = 0.1F;
  float depth_weight = 0;
  float distortion_weight = 0;
};

/// Gain and bias of a view as they are used: observed = gain * radiance + bias.
struct GainBias {
  float gain = 1;
  float bias = 0;
};

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

/// Per ray: the mean over channels of Huber(gain vignetting C + bias - target), for a ray through a
/// depth point also
///   depth_weight Sum w_i (min(1, ((t_i - range) / s)^2) - 1),  s = 3 % of the range,
/// which draws weight to the point and, being bounded, forgives a wrong point; and for all rays
///   distortion_weight (Sum_ij w_i w_j |t_i - t_j| + 1/3 Sum w_i^2 dt_i)   (Mip-NeRF 360, eq. 15).
/// With w_i = T_i (1 - exp(-sigma_i dt_i)):
///   d loss / d sigma_i = dt_i (T_{i+1} d loss / d w_i - Sum_{j > i} w_j d loss / d w_j),
/// where the far background counts as a last sample that all the remaining light reaches.
void ComputeLoss(const RadianceField& field,
                 const Trace& trace,
                 const std::vector<RayTarget>& targets,
                 const std::vector<GainBias>& exposures,
                 const LossOptions& options,
                 LossGradient* gradient);

}  // namespace deja_view::nerf::internal
