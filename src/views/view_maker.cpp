#include "deja_view/views/view_maker.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/camera/depth_image.hpp"
#include "deja_view/features/make_feature_extractor.hpp"
#include "deja_view/views/virtual_features.hpp"

#include <cmath>

#include <opencv2/imgproc.hpp>

namespace deja_view {
std::vector<std::string> ViewOptions::Validate() const {
  Requirements r;
  r.Group("poses", poses.Validate());
  r.Group("sources", sources.Validate());
  r.Group("sampling", sampling.Validate());
  r.Group("choice", choice.Validate());
  r.Group("gate", gate.Validate());
  r.Group("rendering", rendering.Validate());
  r.Group("features", features.Validate());
  r.Range("fit_scale", fit_scale, 0.01, 1);
  r.Range("min_correlation", min_correlation, -1, 1);
  r.Range("jpeg_quality", jpeg_quality, 1, 100);
  return r.errors();
}

ViewMaker::ViewMaker(const ViewOptions& options,
                     const ViewContent& content,
                     std::shared_ptr<const Camera> camera,
                     std::vector<Eigen::Vector3d> flown_N,
                     std::uint64_t settings_hash)
    : options_(options),
      content_(content),
      camera_(std::move(camera)),
      gate_(options.gate, camera_, std::move(flown_N)),
      upscaler_(options.rendering),
      settings_hash_(settings_hash) {
  DEJA_VIEW_CHECK(options.Validate().empty());
  DEJA_VIEW_CHECK(content.image || content.features);
  if (content.features) {
    extractor_ = MakeFeatureExtractor(options.features);
  }
}

ViewMaker::~ViewMaker() = default;

MadeViews ViewMaker::Make(const ViewSource& source,
                          const ViewRenderer& renderer,
                          int threads) const {
  DEJA_VIEW_CHECK(source.image.type() == CV_8UC1 && source.image.cols == camera_->width() &&
                  source.image.rows == camera_->height());
  MadeViews made;
  made.fit = FitSourceExposure(
      renderer, *camera_, source, options_.fit_scale, options_.gate.min_opacity, threads);
  if (made.fit.correlation < options_.min_correlation) {
    made.is_recognised = false;
    return made;
  }
  ViewRenderOptions render_options{1, 0, threads};
  if (options_.exposure == ViewExposure::kSource) {
    render_options.gain = static_cast<float>(made.fit.gain);
    render_options.bias = static_cast<float>(made.fit.bias);
  }
  if (options_.own_image) {
    RenderedView own = renderer.Render(*camera_, source.T_N_C, render_options);
    own.image = source.image;
    made.views.push_back(MakeView(own, source.T_N_C, Rigid3::Identity()));
  }
  const ChosenViews chosen = FindPoses(source, renderer);
  made.not_free = chosen.not_free;
  made.uncertain = chosen.uncertain;
  for (const Rigid3& T_C_V : chosen.T_C_V) {
    made.views.push_back(
        MakeView(upscaler_.Render(renderer, *camera_, source.T_N_C * T_C_V, render_options),
                 source.T_N_C,
                 T_C_V));
  }
  for (std::size_t i = 0; i < made.views.size(); ++i) {
    made.views[i].stamp_ns = source.stamp_ns;
    made.views[i].index = static_cast<std::int32_t>(i);
    made.views[i].count = static_cast<std::int32_t>(made.views.size());
  }
  return made;
}

ChosenViews ViewMaker::FindPoses(const ViewSource& source, const ViewRenderer& renderer) const {
  if (source.chosen) {
    return *source.chosen;
  }
  ChosenViews chosen;
  const auto accept = [&](const Rigid3& T_C_V) {
    const GateVerdict verdict = gate_.Judge(renderer, source.T_N_C, T_C_V);
    chosen.not_free += verdict == GateVerdict::kNotFree ? 1 : 0;
    chosen.uncertain += verdict == GateVerdict::kUncertain ? 1 : 0;
    return verdict == GateVerdict::kAccepted;
  };
  chosen.T_C_V = SampleViews(options_.sampling, source.stamp_ns, accept);
  return chosen;
}

VirtualView ViewMaker::MakeView(const RenderedView& rendered,
                                const Rigid3& T_N_C,
                                const Rigid3& T_C_V) const {
  VirtualView view;
  view.T_C_V = T_C_V;
  view.camera = camera_;
  view.settings_hash = settings_hash_;
  if (content_.image) {
    view.image = rendered.image;
  }
  if (content_.features) {
    view.features =
        ExtractVirtualFeatures(rendered,
                               *extractor_,
                               MakeVerticalField(options_.features, *camera_, (T_N_C * T_C_V).q),
                               options_.gate.min_opacity);
  }
  if (content_.depth) {
    view.depth_mm = ToMillimetres(rendered.depth);
    view.certainty = CertaintyOf(rendered, options_.gate);
  }
  return view;
}

ExposureFit FitSourceExposure(const ViewRenderer& renderer,
                              const Camera& camera,
                              const ViewSource& source,
                              double scale,
                              double min_opacity,
                              int threads) {
  const std::unique_ptr<Camera> small_camera = camera.Scaled(scale);
  RenderedView view = renderer.Render(*small_camera, source.T_N_C, {1, 0, threads});
  if (view.image.channels() == 3) {
    cv::cvtColor(view.image.clone(), view.image, cv::COLOR_BGR2GRAY);
  }
  cv::Mat real;
  cv::resize(source.image, real, view.image.size(), 0, 0, cv::INTER_AREA);
  return FitExposure(view.image, real, view.opacity, min_opacity);
}

}  // namespace deja_view
