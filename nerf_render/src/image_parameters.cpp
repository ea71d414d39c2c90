#include "image_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

namespace deja_view::nerf::internal {
namespace {

constexpr float kVignettingRate = 4;  ///< of a gain's: it is multiplied by numbers well below 1

// Adam's kernels work on multiples of 16.
std::size_t Padded(std::size_t size) {
  return (size + 15) / 16 * 16;
}

void AdamUpdate(const Kernels& kernels,
                float learning_rate,
                DenseAdam* adam,
                std::vector<float>* parameters) {
  AdamStep step;
  step.learning_rate = learning_rate;
  kernels.adam(step,
               parameters->size(),
               parameters->data(),
               adam->gradient.data(),
               adam->first.data(),
               adam->second.data());
}

// Holds the mean over all views of every one of `stride` numbers at 0: what all images share
// belongs to the field.
void Center(std::size_t views, std::size_t stride, std::vector<float>* values) {
  for (std::size_t i = 0; i < stride; ++i) {
    double mean = 0;
    for (std::size_t v = 0; v < views; ++v) {
      mean += static_cast<double>((*values)[v * stride + i]);
    }
    mean /= static_cast<double>(views);
    for (std::size_t v = 0; v < views; ++v) {
      (*values)[v * stride + i] -= static_cast<float>(mean);
    }
  }
}

}  // namespace

ImageParameters::ImageParameters(const TrainOptions& options,
                                 const std::vector<TrainingView>& views,
                                 RadianceField* field)
    : options_(options),
      views_(views.size()),
      gain_bias_(views.size()),
      exposure_(Padded(2 * views.size()), 0.0F),
      vignetting_(Padded(field->vignetting.k.size()), 0.0F),
      latent_(Padded(views.size() * static_cast<std::size_t>(options.field.latent_size)), 0.0F),
      exposure_adam_(exposure_.size()),
      vignetting_adam_(vignetting_.size()),
      latent_adam_(latent_.size()) {
  std::map<std::string, Exposure> known;
  for (const Exposure& exposure : field->exposures) {
    known[exposure.image] = exposure;
  }
  field->exposures.clear();
  const auto size = static_cast<std::size_t>(options.field.latent_size);
  for (std::size_t v = 0; v < views.size(); ++v) {
    Exposure exposure;
    if (const auto found = known.find(views[v].name); found != known.end()) {
      exposure = found->second;
    }
    exposure.image = views[v].name;
    exposure.stamp_ns = views[v].stamp_ns;
    exposure.latent.resize(size, 0.0F);
    exposure_[2 * v] = std::log(exposure.gain);
    exposure_[2 * v + 1] = exposure.bias;
    gain_bias_[v] = {exposure.gain, exposure.bias};
    std::copy(exposure.latent.begin(),
              exposure.latent.end(),
              latent_.begin() + static_cast<std::ptrdiff_t>(v * size));
    field->exposures.push_back(std::move(exposure));
    T_N_C_.push_back(views[v].T_N_C);
  }
  std::copy(field->vignetting.k.begin(), field->vignetting.k.end(), vignetting_.begin());
}

const float* ImageParameters::latent(std::size_t view) const {
  const auto size = static_cast<std::size_t>(options_.field.latent_size);
  return size > 0 ? latent_.data() + view * size : nullptr;
}

void ImageParameters::Update(const Kernels& kernels,
                             const std::vector<ImageGradient>& chunks,
                             float rate,
                             RadianceField* field) {
  const auto size = static_cast<std::size_t>(options_.field.latent_size);
  for (const ImageGradient& chunk : chunks) {
    for (std::size_t r = 0; r < chunk.targets.size(); ++r) {
      const RayTarget& target = chunk.targets[r];
      const std::size_t v = target.view;
      const float d_log_gain = chunk.d_exposure[r].gain * gain_bias_[v].gain;
      exposure_adam_.gradient[2 * v] += d_log_gain;
      exposure_adam_.gradient[2 * v + 1] += chunk.d_exposure[r].bias;
      float power = target.off_axis;
      for (std::size_t i = 0; i < field->vignetting.k.size(); ++i) {
        vignetting_adam_.gradient[i] += d_log_gain * power;
        power *= target.off_axis;
      }
      for (std::size_t i = 0; i < size; ++i) {
        latent_adam_.gradient[v * size + i] += chunk.d_latent[r * size + i];
      }
    }
  }
  UpdateExposures(kernels, rate, field);
  UpdateLatents(kernels, rate, field);
}

void ImageParameters::UpdateExposures(const Kernels& kernels, float rate, RadianceField* field) {
  const float learning_rate = rate * options_.exposure_learning_rate;
  if (options_.vignetting) {
    AdamUpdate(kernels, kVignettingRate * learning_rate, &vignetting_adam_, &vignetting_);
    std::copy_n(vignetting_.begin(), field->vignetting.k.size(), field->vignetting.k.begin());
  }
  if (!options_.exposure) {
    return;
  }
  AdamUpdate(kernels, learning_rate, &exposure_adam_, &exposure_);
  Center(views_, 2, &exposure_);
  for (std::size_t v = 0; v < views_; ++v) {
    gain_bias_[v] = {std::exp(exposure_[2 * v]), exposure_[2 * v + 1]};
    field->exposures[v].gain = gain_bias_[v].gain;
    field->exposures[v].bias = gain_bias_[v].bias;
  }
}

void ImageParameters::UpdateLatents(const Kernels& kernels, float rate, RadianceField* field) {
  const auto size = static_cast<std::size_t>(options_.field.latent_size);
  if (size == 0) {
    return;
  }
  AdamUpdate(kernels, rate * options_.exposure_learning_rate, &latent_adam_, &latent_);
  Center(views_, size, &latent_);
  for (std::size_t v = 0; v < views_; ++v) {
    std::copy_n(latent(v), size, field->exposures[v].latent.begin());
  }
}

}  // namespace deja_view::nerf::internal
