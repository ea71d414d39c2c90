#pragma once

#include "deja_view/nerf/field_renderer.hpp"
#include "deja_view/nerf/posed_images.hpp"

#include <filesystem>
#include <vector>

namespace deja_view {

/// Renders held-out images one at a time and gathers how near they come.
class NerfEvaluation {
 public:
  /// `load_options` say how images are decoded; their channels are set to the field's. Pictures
  /// real | rendered | difference go to `pictures` unless it is empty. The renderer must live on.
  NerfEvaluation(const nerf::FieldRenderer& renderer,
                 const nerf::LoadOptions& load_options,
                 const std::filesystem::path& pictures);

  /// Throws InputError for an image that can't be read. `neighbour`, if given, is an image taken
  /// near it: it is seen from `image`'s pose with the field's depth, as the ceiling of what renders
  /// can reach.
  void Compare(const nerf::PosedImage& image, const nerf::PosedImage* neighbour);
  void CompareDepthOnly(const nerf::PosedImage& image);

  /// One entry per Compare.
  const std::vector<double>& psnr_db() const { return psnr_db_; }
  const std::vector<double>& ssim() const { return ssim_; }
  const std::vector<double>& corner_match_rate() const { return corner_match_rate_; }
  /// One per Compare with a neighbour.
  const std::vector<double>& corner_match_ceiling() const { return corner_match_ceiling_; }
  /// One per rendered view [ms].
  const std::vector<double>& render_ms() const { return render_ms_; }
  /// One per pixel of a view with a depth map.
  const std::vector<double>& depth_errors() const { return depth_errors_; }
  std::size_t depth_views() const { return depth_views_; }

 private:
  nerf::TrainingView Load(const nerf::PosedImage& image) const;
  RenderedView Render(const nerf::TrainingView& real);
  /// `rendered` by the image's camera; another depth camera's view is rendered here.
  void CompareDepth(const nerf::PosedImage& image, const RenderedView& rendered);

  const nerf::FieldRenderer& renderer_;
  nerf::LoadOptions load_options_;
  std::filesystem::path pictures_;
  std::vector<double> psnr_db_;
  std::vector<double> ssim_;
  std::vector<double> corner_match_rate_;
  std::vector<double> corner_match_ceiling_;
  std::vector<double> render_ms_;
  std::vector<double> depth_errors_;
  std::size_t depth_views_ = 0;
};

}  // namespace deja_view
