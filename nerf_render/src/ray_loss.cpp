#include "ray_loss.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view::nerf::internal {
namespace {

constexpr float kDepthTolerance = 0.03F;  ///< share of the range

/// The samples of one ray, [begin, end) of the trace.
struct Span {
  std::size_t begin, end;
};

// Adds the distortion loss of one ray to *loss and its derivatives to d_weight, in linear time:
// with t ascending, Sum_j w_j |t_i - t_j| = t_i (2 W_i + w_i - W) - (2 S_i + w_i t_i - S), where
// W_i and S_i are the sums of w and w t before i.
void AddDistortion(
    const Trace& trace, Span span, float factor, double* loss, std::vector<float>* d_weight) {
  float total = 0;
  float total_t = 0;
  for (std::size_t s = span.begin; s < span.end; ++s) {
    total += trace.weight[s];
    total_t += trace.weight[s] * trace.t[s];
  }
  float before = 0;
  float before_t = 0;
  for (std::size_t s = span.begin; s < span.end; ++s) {
    const float w = trace.weight[s];
    const float t = trace.t[s];
    const float spread = t * (2 * before + w - total) - (2 * before_t + w * t - total_t);
    (*d_weight)[s] += factor * (2 * spread + 2.0F / 3.0F * w * trace.dt[s]);
    *loss += static_cast<double>(factor * (w * spread + w * w * trace.dt[s] / 3));
    before += w;
    before_t += w * t;
  }
}

void AddDepth(const Trace& trace,
              Span span,
              float range,
              float factor,
              double* loss,
              std::vector<float>* d_weight) {
  for (std::size_t s = span.begin; s < span.end; ++s) {
    const float error = (trace.t[s] - range) / (kDepthTolerance * range);
    const float d = factor * (std::min(1.0F, error * error) - 1);
    *loss += static_cast<double>(d * trace.weight[s]);
    (*d_weight)[s] += d;
  }
}

float Huber(float error, float delta) {
  const float size = std::abs(error);
  return size < delta ? 0.5F * error * error : delta * (size - 0.5F * delta);
}

// Colour loss of one ray; fills its rows of d_color_rows. Adds to *behind the background's weight
// times the loss' derivative by it.
void AddColor(const RadianceField& field,
              const Trace& trace,
              Span span,
              const RayTarget& target,
              const GainBias& exposure,
              float delta,
              std::size_t ray,
              std::vector<float>* d_weight,
              float* behind,
              LossGradient* gradient) {
  const auto channels = static_cast<std::size_t>(field.channels);
  const auto stride = static_cast<std::size_t>(field.color.output_stride());
  const auto background_stride =
      trace.background.empty() ? std::size_t{0}
                               : static_cast<std::size_t>(field.background_color.output_stride());
  const float share = 1.0F / static_cast<float>(channels);
  const float gain = exposure.gain * target.vignetting;
  for (std::size_t c = 0; c < channels; ++c) {
    float radiance = 0;
    for (std::size_t s = span.begin; s < span.end; ++s) {
      radiance += trace.weight[s] * trace.color[s * channels + c];
    }
    const bool has_background = !trace.background.empty();
    const float background = has_background ? trace.background[ray * channels + c] : 0.0F;
    radiance += trace.transmittance[ray] * background;
    const float error = gain * radiance + exposure.bias - target.color[c];
    gradient->squared_error += static_cast<double>(error * error);
    gradient->loss += static_cast<double>(share * Huber(error, delta));
    const float d_observed = share * std::clamp(error, -delta, delta);
    gradient->d_exposure[ray].gain += d_observed * target.vignetting * radiance;
    gradient->d_exposure[ray].bias += d_observed;
    const float d_radiance = d_observed * gain;
    if (has_background) {
      const float passed = d_radiance * trace.transmittance[ray];
      *behind += passed * background;
      gradient->d_background_rows[ray * background_stride + c] =
          passed * background * (1 - background);
    }
    for (std::size_t s = span.begin; s < span.end; ++s) {
      const float color = trace.color[s * channels + c];
      (*d_weight)[s] += d_radiance * color;
      gradient->d_color_rows[s * stride + c] = d_radiance * trace.weight[s] * color * (1 - color);
    }
  }
  gradient->color_values += channels;
}

}  // namespace

void ComputeLoss(const RadianceField& field,
                 const Trace& trace,
                 const std::vector<RayTarget>& targets,
                 const std::vector<GainBias>& exposures,
                 const LossOptions& options,
                 LossGradient* gradient) {
  const std::size_t count = trace.size();
  gradient->d_raw.resize(count);
  gradient->d_color_rows.assign(count * static_cast<std::size_t>(field.color.output_stride()),
                                0.0F);
  gradient->d_background_rows.assign(
      trace.background.empty()
          ? 0
          : targets.size() * static_cast<std::size_t>(field.background_color.output_stride()),
      0.0F);
  gradient->d_exposure.assign(targets.size(), {0, 0});
  gradient->loss = 0;
  gradient->squared_error = 0;
  gradient->color_values = 0;
  std::vector<float> d_weight(count, 0.0F);
  for (std::size_t r = 0; r < targets.size(); ++r) {
    const Span span{trace.ray_begin[r], trace.ray_begin[r + 1]};
    float behind = 0;
    if (targets[r].range > 0) {
      AddDepth(trace, span, targets[r].range, options.depth_weight, &gradient->loss, &d_weight);
    }
    AddColor(field,
             trace,
             span,
             targets[r],
             exposures[targets[r].view],
             options.huber_delta,
             r,
             &d_weight,
             &behind,
             gradient);
    AddDistortion(trace, span, options.distortion_weight, &gradient->loss, &d_weight);
    for (std::size_t s = span.end; s-- > span.begin;) {
      const float d_sigma = trace.dt[s] * (trace.after[s] * d_weight[s] - behind);
      gradient->d_raw[s] = d_sigma * trace.sigma[s];
      behind += trace.weight[s] * d_weight[s];
    }
  }
}

}  // namespace deja_view::nerf::internal
