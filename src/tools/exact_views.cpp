#include "exact_views.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/features/make_feature_extractor.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/pipeline/virtual_features.hpp"

#include <chrono>
#include <optional>

#include "interrupt.hpp"
#ifdef DEJA_VIEW_WITH_ROS
#include "flight_bag.hpp"
#endif

namespace deja_view {

ExactViews::ExactViews(const sim::Simulator& simulator, const SimulateRequest& request)
    : simulator_(simulator),
      options_(sim::MakeExactViewPreset(request.virtual_views)),
      content_(request.virtual_content),
      extractor_(MakeFeatureExtractor(FeatureOptions{})) {}

std::vector<VirtualView> ExactViews::Render(std::int64_t stamp_ns) const {
  const double t = 1e-9 * static_cast<double>(stamp_ns - simulator_.options().start_stamp_ns);
  const Rigid3 T_W_C = simulator_.path().Pose(t) * simulator_.T_B_C();
  const auto poses = sim::SampleExactViewPoses(
      *simulator_.world(), T_W_C, options_, static_cast<std::uint64_t>(stamp_ns));
  std::vector<VirtualView> views;
  for (const Rigid3& T_C_V : poses) {
    VirtualView view =
        sim::RenderExactView(simulator_.renderer(), simulator_.camera(), T_W_C, T_C_V, options_);
    view.stamp_ns = stamp_ns;
    view.index = static_cast<std::int32_t>(views.size());
    view.count = static_cast<std::int32_t>(poses.size());
    if (content_ != "image") {
      view.features = ExtractVirtualFeatures(view, *extractor_, 0.0);
    }
    if (content_ == "features") {
      view.image = view.depth_mm = cv::Mat();
    }
    views.push_back(std::move(view));
  }
  return views;
}

#ifdef DEJA_VIEW_WITH_ROS
nlohmann::ordered_json RunSimulateViews(const SimulateRequest& request) {
  const Interrupt interrupt;
  const auto begin = std::chrono::steady_clock::now();
  const sim::Simulator simulator(ReadSimOptions(request));
  const ExactViews views(simulator, request);
  const std::vector<std::int64_t> stamps = ReadTum(request.views_for).stamps_ns;
  FlightBag bag(request.out / "views.bag", simulator.camera(), simulator.T_B_C());
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("views", "images", stamps.size());
  }
  std::size_t count = 0;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    interrupt.Check();
    for (const VirtualView& view : views.Render(stamps[i])) {
      bag.AddVirtualView(stamps[i], view);
      ++count;
    }
    if (progress) {
      progress->Update(i + 1);
    }
  }
  bag.Close();
  if (progress) {
    progress->Finish(stamps.size());
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  return {{"virtual_views", count}, {"wall_s", wall.count()}};
}
#else
nlohmann::ordered_json RunSimulateViews(const SimulateRequest& request) {
  ThrowInputError("--views-for {}: this deja_view was built without ROS",
                  request.views_for.string());
}
#endif

}  // namespace deja_view
