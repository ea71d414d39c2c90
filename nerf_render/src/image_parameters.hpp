#pragma once

#include "deja_view/nerf/radiance_field.hpp"
#include "deja_view/nerf/training_view.hpp"

#include <vector>

#include "ray_loss.hpp"

namespace deja_view::nerf::internal {

/// Adam's memory for parameters that every step touches.
struct DenseAdam {
  explicit DenseAdam(std::size_t size) : gradient(size), first(size), second(size) {}
  std::vector<float> gradient, first, second;
};

/// Derivatives of one chunk of rays by what belongs to their images.
struct ImageGradient {
  std::vector<RayTarget> targets;
  std::vector<GainBias> d_exposure;  ///< per ray
  std::vector<float> d_latent;       ///< rays x latent_size
};

/// What is trained beside the field: gain, bias and latent of every image, and the lens'
/// vignetting.
class ImageParameters {
 public:
  /// Takes gains, biases and latents of images that the field knows by name from it, and writes one
  /// entry per view to field->exposures.
  ImageParameters(const TrainOptions& options,
                  const std::vector<TrainingView>& views,
                  RadianceField* field);

  const std::vector<GainBias>& gain_bias() const { return gain_bias_; }
  const float* latent(std::size_t view) const;
  const Rigid3& T_N_C(std::size_t view) const { return T_N_C_[view]; }

  /// One step of Adam at `rate` times the options' learning rates.
  void Update(const Kernels& kernels,
              const std::vector<ImageGradient>& chunks,
              float rate,
              RadianceField* field);

 private:
  void UpdateExposures(const Kernels& kernels, float rate, RadianceField* field);
  void UpdateLatents(const Kernels& kernels, float rate, RadianceField* field);

  TrainOptions options_;
  std::size_t views_;
  std::vector<GainBias> gain_bias_;
  std::vector<Rigid3> T_N_C_;
  std::vector<float> exposure_;    ///< per view: logarithm of the gain, bias
  std::vector<float> vignetting_;  ///< three, padded
  std::vector<float> latent_;      ///< per view
  DenseAdam exposure_adam_;
  DenseAdam vignetting_adam_;
  DenseAdam latent_adam_;
};

}  // namespace deja_view::nerf::internal
