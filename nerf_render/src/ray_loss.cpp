#include "ray_loss.hpp"

namespace deja_view::nerf::internal {

void ComputeLoss(const RadianceField& field,
                 const Trace& trace,
                 const std::vector<RayTarget>& targets,
                 const std::vector<GainBias>& exposures,
                 const LossOptions& options,
                 LossGradient* gradient) {
  const std::size_t count = trace.size();
  const auto channels = static_cast<std::size_t>(field.channels);
  const bool has_background = !trace.background.empty();
  RayLoss loss;
  loss.out.color_stride = static_cast<std::size_t>(field.color.output_stride());
  loss.out.background_stride =
      has_background ? static_cast<std::size_t>(field.background_color.output_stride()) : 0;
  std::vector<float> d_weight(count, 0.0F);
  gradient->d_raw.resize(count);
  gradient->d_color_rows.assign(count * loss.out.color_stride, 0.0F);
  gradient->d_background_rows.assign(targets.size() * loss.out.background_stride, 0.0F);
  gradient->d_exposure.assign(targets.size(), {0, 0});
  loss.trace = {trace.ray_begin.data(),
                trace.t.data(),
                trace.dt.data(),
                trace.sigma.data(),
                trace.weight.data(),
                trace.after.data(),
                trace.color.data(),
                trace.transmittance.data(),
                has_background ? trace.background.data() : nullptr,
                channels};
  loss.targets = targets.data();
  loss.exposures = exposures.data();
  loss.options = options;
  loss.out.d_weight = d_weight.data();
  loss.out.d_raw = gradient->d_raw.data();
  loss.out.d_color_rows = gradient->d_color_rows.data();
  loss.out.d_background_rows = gradient->d_background_rows.data();
  loss.out.d_exposure = gradient->d_exposure.data();
  gradient->loss = 0;
  gradient->squared_error = 0;
  for (std::size_t r = 0; r < targets.size(); ++r) {
    const RayLossSum sum = loss(r);
    gradient->loss += sum.loss;
    gradient->squared_error += sum.squared_error;
  }
  gradient->color_values = targets.size() * channels;
}

}  // namespace deja_view::nerf::internal
