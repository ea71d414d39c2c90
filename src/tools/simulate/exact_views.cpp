#include "simulate/exact_views.hpp"

#include "deja_view/features/make_feature_extractor.hpp"
#include "deja_view/views/virtual_features.hpp"

#include <utility>

namespace deja_view {

ExactViews::ExactViews(const sim::Simulator& simulator, const SimulateRequest& request)
    : simulator_(simulator),
      options_(
          sim::MakeExactViewPreset(request.virtual_views.empty() ? "wide" : request.virtual_views)),
      content_(request.virtual_content),
      extractor_(MakeFeatureExtractor(FeatureOptions{})) {}

Rigid3 ExactViews::CameraPose(std::int64_t stamp_ns) const {
  const double t = 1e-9 * static_cast<double>(stamp_ns - simulator_.options().start_stamp_ns);
  return simulator_.path().Pose(t) * sim::SimulatedExtrinsic();
}

VirtualView ExactViews::RenderAt(std::int64_t stamp_ns, const Rigid3& T_C_V) const {
  VirtualView view = sim::RenderExactView(
      simulator_.renderer(), simulator_.camera(), CameraPose(stamp_ns), T_C_V, options_);
  view.stamp_ns = stamp_ns;
  if (content_ != "image") {
    const Rigid3 T_W_V = CameraPose(stamp_ns) * T_C_V;
    view.features = ExtractVirtualFeatures(
        view, *extractor_, MakeVerticalField(FeatureOptions{}, *view.camera, T_W_V.q), 0.0);
  }
  if (content_ == "features") {
    view.image = view.depth_mm = cv::Mat();
  }
  return view;
}

std::vector<VirtualView> ExactViews::Render(std::int64_t stamp_ns) const {
  const auto poses = sim::SampleExactViewPoses(
      *simulator_.world(), CameraPose(stamp_ns), options_, static_cast<std::uint64_t>(stamp_ns));
  std::vector<VirtualView> views;
  for (const Rigid3& T_C_V : poses) {
    VirtualView view = RenderAt(stamp_ns, T_C_V);
    view.index = static_cast<std::int32_t>(views.size());
    view.count = static_cast<std::int32_t>(poses.size());
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace deja_view
