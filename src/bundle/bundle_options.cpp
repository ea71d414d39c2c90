#include "deja_view/bundle/bundle_options.hpp"

#include "deja_view/base/requirements.hpp"

namespace deja_view {
namespace {

constexpr const char* kPositive = "more than 0";
constexpr const char* kNotNegative = "0 or more";

}  // namespace

std::vector<std::string> BundleCameraSigmas::Validate() const {
  Requirements r;
  r.That(focal > 0, "focal", focal, kPositive);
  r.That(centre_px > 0, "centre_px", centre_px, kPositive);
  r.That(distortion > 0, "distortion", distortion, kPositive);
  r.That(extrinsic_m > 0, "extrinsic_m", extrinsic_m, kPositive);
  r.That(extrinsic_deg > 0, "extrinsic_deg", extrinsic_deg, kPositive);
  r.That(time_offset_s > 0, "time_offset_s", time_offset_s, kPositive);
  return r.errors();
}

std::vector<std::string> BundleOptions::Validate() const {
  Requirements r;
  r.That(neighbours >= 0, "neighbours", neighbours, kNotNegative);
  r.That(overlapping >= 0, "overlapping", overlapping, kNotNegative);
  r.That(max_view_deg > 0 && max_view_deg <= 180,
         "max_view_deg",
         max_view_deg,
         "more than 0, at most 180");
  r.That(reach_m > 0, "reach_m", reach_m, kPositive);
  r.Range("max_hamming", max_hamming, 0, 256);
  r.That(max_hamming_ratio > 0 && max_hamming_ratio <= 1,
         "max_hamming_ratio",
         max_hamming_ratio,
         "more than 0, at most 1");
  r.That(rounds >= 1, "rounds", rounds, "1 or more");
  r.That(last_error_px > 0, "last_error_px", last_error_px, kPositive);
  r.That(
      first_error_px >= last_error_px, "first_error_px", first_error_px, "last_error_px or more");
  r.That(min_parallax_deg > 0, "min_parallax_deg", min_parallax_deg, kPositive);
  r.That(min_views >= 2, "min_views", min_views, "2 or more");
  r.That(points_per_image >= 0, "points_per_image", points_per_image, kNotNegative);
  r.That(min_points >= 3, "min_points", min_points, "3 or more");
  r.That(max_iterations >= 1, "max_iterations", max_iterations, "1 or more");
  r.That(pixel_sigma > 0, "pixel_sigma", pixel_sigma, kPositive);
  r.That(kernel_sigmas > 0, "kernel_sigmas", kernel_sigmas, kPositive);
  r.That(prior_kernel_sigmas > 0, "prior_kernel_sigmas", prior_kernel_sigmas, kPositive);
  r.That(tolerance > 0, "tolerance", tolerance, kPositive);
  r.That(threads >= 0, "threads", threads, kNotNegative);
  r.Group("camera_sigmas", camera_sigmas.Validate());
  return r.errors();
}

}  // namespace deja_view
