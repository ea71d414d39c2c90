#pragma once

#include "deja_view/base/host_device.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace deja_view::nerf::internal {

/// What one training ray should show.
struct RayTarget {
  std::uint32_t view = 0;
  std::array<float, 3> color = {};  ///< [white]
  float range = 0;                  ///< of a depth point, in unit lengths; 0: unknown
  float off_axis = 0;               ///< 1 - z of the camera's unit ray
  float vignetting = 1;             ///< there
  float backdrop = 0;               ///< radiance that a ray ends on if LossOptions::opaque
};

/// A ray's own number in [0, 1): the digits of its jitter that move its samples by next to nothing.
DEJA_VIEW_HOST_DEVICE inline float BackdropOf(float jitter) {
  const float digits = 1024 * jitter;
  return digits - std::floor(digits);
}

/// Weights of the losses, from TrainOptions.
struct LossOptions {
  float huber_delta = 0.1F;
  float depth_weight = 0;
  float distortion_weight = 0;
  bool opaque = false;  ///< without a far background, what light passes shows RayTarget::backdrop
};

/// Gain and bias of a view as they are used: observed = gain * radiance + bias.
struct GainBias {
  float gain = 1;
  float bias = 0;
};

/// The traced samples of some rays, as Trace has them.
struct TraceView {
  const std::size_t* ray_begin = nullptr;
  const float* t = nullptr;
  const float* dt = nullptr;
  const float* sigma = nullptr;
  const float* weight = nullptr;
  const float* after = nullptr;
  const float* color = nullptr;
  const float* transmittance = nullptr;
  const float* background = nullptr;  ///< null without a far background
  std::size_t channels = 1;
};

/// Where the losses' derivatives go.
struct LossRows {
  float* d_weight = nullptr;      ///< per sample, 0 at first
  float* d_raw = nullptr;         ///< per sample: d loss / d log density
  float* d_color_rows = nullptr;  ///< per sample: d loss / d (before the sigmoid), 0 at first
  std::size_t color_stride = 0;
  float* d_background_rows = nullptr;  ///< per ray, as d_color_rows
  std::size_t background_stride = 0;
  GainBias* d_exposure = nullptr;  ///< per ray, 0 at first
};

/// What the losses of one ray add up to.
struct RayLossSum {
  double loss = 0;
  double squared_error = 0;  ///< over the channels
};

/// Per ray: the mean over channels of Huber(gain vignetting C + bias - target), for a ray through a
/// depth point also
///   depth_weight Sum w_i (min(1, ((t_i - range) / s)^2) - 1),  s = 3 % of the range,
/// which draws weight to the point and, being bounded, forgives a wrong point; and for all rays
///   distortion_weight (Sum_ij w_i w_j |t_i - t_j| + 1/3 Sum w_i^2 dt_i)   (Mip-NeRF 360, eq. 15).
/// With w_i = T_i (1 - exp(-sigma_i dt_i)):
///   d loss / d sigma_i = dt_i (T_{i+1} d loss / d w_i - Sum_{j > i} w_j d loss / d w_j),
/// where the far background counts as a last sample that all the remaining light reaches. So does
/// the backdrop: as it differs from ray to ray, only a field that lets no light pass explains an
/// image, and dark surfaces are not mistaken for nothing.
struct RayLoss {
  TraceView trace;
  const RayTarget* targets = nullptr;
  const GainBias* exposures = nullptr;  ///< per view
  LossOptions options;
  LossRows out;

  DEJA_VIEW_HOST_DEVICE RayLossSum operator()(std::size_t ray) const;

 private:
  static constexpr float kDepthTolerance = 0.03F;  ///< share of the range

  /// What the light shows that passes all samples.
  DEJA_VIEW_HOST_DEVICE float Background(std::size_t ray, std::size_t channel) const {
    if (trace.background != nullptr) {
      return trace.background[ray * trace.channels + channel];
    }
    return options.opaque ? targets[ray].backdrop : 0.0F;
  }
  DEJA_VIEW_HOST_DEVICE void AddDepth(std::size_t ray, RayLossSum* sum) const;
  DEJA_VIEW_HOST_DEVICE void AddColor(std::size_t ray,
                                      std::size_t channel,
                                      float* behind,
                                      RayLossSum* sum) const;
  DEJA_VIEW_HOST_DEVICE void AddDistortion(std::size_t ray, RayLossSum* sum) const;
};

// Adds the distortion loss of one ray and its derivatives, in linear time: with t ascending,
// Sum_j w_j |t_i - t_j| = t_i (2 W_i + w_i - W) - (2 S_i + w_i t_i - S), where W_i and S_i are the
// sums of w and w t before i.
DEJA_VIEW_HOST_DEVICE inline void RayLoss::AddDistortion(std::size_t ray, RayLossSum* sum) const {
  const std::size_t begin = trace.ray_begin[ray];
  const std::size_t end = trace.ray_begin[ray + 1];
  const float factor = options.distortion_weight;
  float total = 0;
  float total_t = 0;
  for (std::size_t s = begin; s < end; ++s) {
    total += trace.weight[s];
    total_t += trace.weight[s] * trace.t[s];
  }
  float before = 0;
  float before_t = 0;
  for (std::size_t s = begin; s < end; ++s) {
    const float w = trace.weight[s];
    const float t = trace.t[s];
    const float spread = t * (2 * before + w - total) - (2 * before_t + w * t - total_t);
    out.d_weight[s] += factor * (2 * spread + 2.0F / 3.0F * w * trace.dt[s]);
    sum->loss += static_cast<double>(factor * (w * spread + w * w * trace.dt[s] / 3));
    before += w;
    before_t += w * t;
  }
}

DEJA_VIEW_HOST_DEVICE inline void RayLoss::AddDepth(std::size_t ray, RayLossSum* sum) const {
  const float range = targets[ray].range;
  for (std::size_t s = trace.ray_begin[ray]; s < trace.ray_begin[ray + 1]; ++s) {
    const float error = (trace.t[s] - range) / (kDepthTolerance * range);
    const float d = options.depth_weight * (std::min(1.0F, error * error) - 1);
    sum->loss += static_cast<double>(d * trace.weight[s]);
    out.d_weight[s] += d;
  }
}

DEJA_VIEW_HOST_DEVICE inline float Huber(float error, float delta) {
  const float size = std::abs(error);
  return size < delta ? 0.5F * error * error : delta * (size - 0.5F * delta);
}

// Colour loss of one channel; fills its column of d_color_rows. Adds to *behind the background's
// weight times the loss' derivative by it.
DEJA_VIEW_HOST_DEVICE inline void RayLoss::AddColor(std::size_t ray,
                                                    std::size_t c,
                                                    float* behind,
                                                    RayLossSum* sum) const {
  const RayTarget& target = targets[ray];
  const GainBias& exposure = exposures[target.view];
  const std::size_t begin = trace.ray_begin[ray];
  const std::size_t end = trace.ray_begin[ray + 1];
  const float delta = options.huber_delta;
  const float share = 1.0F / static_cast<float>(trace.channels);
  const float gain = exposure.gain * target.vignetting;
  float radiance = 0;
  for (std::size_t s = begin; s < end; ++s) {
    radiance += trace.weight[s] * trace.color[s * trace.channels + c];
  }
  const bool has_background = trace.background != nullptr;
  if (has_background) {
    radiance += trace.transmittance[ray] * trace.background[ray * trace.channels + c];
  }
  const float shown_error = gain * radiance + exposure.bias - target.color[c];
  sum->squared_error += static_cast<double>(shown_error * shown_error);
  const float background = Background(ray, c);
  if (!has_background) {
    radiance += trace.transmittance[ray] * background;
  }
  const float error = gain * radiance + exposure.bias - target.color[c];
  sum->loss += static_cast<double>(share * Huber(error, delta));
  const float d_observed = share * std::clamp(error, -delta, delta);
  out.d_exposure[ray].gain += d_observed * target.vignetting * radiance;
  out.d_exposure[ray].bias += d_observed;
  const float d_radiance = d_observed * gain;
  const float passed = d_radiance * trace.transmittance[ray];
  *behind += passed * background;
  if (has_background) {
    out.d_background_rows[ray * out.background_stride + c] = passed * background * (1 - background);
  }
  for (std::size_t s = begin; s < end; ++s) {
    const float color = trace.color[s * trace.channels + c];
    out.d_weight[s] += d_radiance * color;
    out.d_color_rows[s * out.color_stride + c] = d_radiance * trace.weight[s] * color * (1 - color);
  }
}

DEJA_VIEW_HOST_DEVICE inline RayLossSum RayLoss::operator()(std::size_t ray) const {
  RayLossSum sum;
  float behind = 0;
  if (targets[ray].range > 0) {
    AddDepth(ray, &sum);
  }
  for (std::size_t c = 0; c < trace.channels; ++c) {
    AddColor(ray, c, &behind, &sum);
  }
  AddDistortion(ray, &sum);
  for (std::size_t s = trace.ray_begin[ray + 1]; s-- > trace.ray_begin[ray];) {
    const float d_sigma = trace.dt[s] * (trace.after[s] * out.d_weight[s] - behind);
    out.d_raw[s] = d_sigma * trace.sigma[s];
    behind += trace.weight[s] * out.d_weight[s];
  }
  return sum;
}

}  // namespace deja_view::nerf::internal
