#include "simulate/simulate_views.hpp"

#include "deja_view/base/check.hpp"
#ifdef DEJA_VIEW_WITH_ROS
#include "deja_view/base/progress.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/bag_replay.hpp"
#include "deja_view/ros/messages/virtual_frame_conversion.hpp"

#include <chrono>
#include <functional>
#include <optional>

#include "common/interrupt.hpp"
#include "simulate/exact_views.hpp"
#include "simulate/flight_bag.hpp"
#endif

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

#ifdef DEJA_VIEW_WITH_ROS
/// What a view shares with the exact one in its place.
struct ViewPlace {
  std::int64_t stamp_ns;
  std::int32_t index;
  std::int32_t count;
  Rigid3 T_C_V;
};

std::vector<ViewPlace> ReadViewPlaces(const std::filesystem::path& file) {
  const std::string topic = VioTopics{}.virtual_frame;
  const BagReader bag(file);
  RequireVirtualViews(bag, topic);
  std::vector<ViewPlace> places;
  bag.Read({topic}, [&](const rosbag::MessageInstance& instance) {
    const VirtualView view = FromVirtualFrame(*Instantiate<VirtualFrame>(instance), topic);
    places.push_back({view.stamp_ns, view.index, view.count, view.T_C_V});
  });
  return places;
}

/// Renders `count` times what `render(i)` gives, into out/views.bag.
Json WriteViews(const SimulateRequest& request,
                const sim::Simulator& simulator,
                std::size_t count,
                const std::function<std::vector<VirtualView>(std::size_t)>& render) {
  const Interrupt interrupt;
  const auto begin = std::chrono::steady_clock::now();
  FlightBag bag(request.out / "views.bag", simulator.camera(), sim::SimulatedExtrinsic());
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("views", "steps", count);
  }
  std::size_t views = 0;
  for (std::size_t i = 0; i < count; ++i) {
    interrupt.Check();
    for (const VirtualView& view : render(i)) {
      bag.AddVirtualView(view.stamp_ns, view);
      ++views;
    }
    if (progress) {
      progress->Update(i + 1);
    }
  }
  bag.Close();
  if (progress) {
    progress->Finish(count);
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  return {{"virtual_views", views}, {"wall_s", wall.count()}};
}
#endif

}  // namespace

#ifdef DEJA_VIEW_WITH_ROS
Json RunSimulateViews(const SimulateRequest& request) {
  const sim::Simulator simulator(ReadSimOptions(request));
  const ExactViews views(simulator, request);
  if (request.views_like.empty()) {
    const std::vector<std::int64_t> stamps = ReadTum(request.views_for).stamps_ns;
    return WriteViews(
        request, simulator, stamps.size(), [&](std::size_t i) { return views.Render(stamps[i]); });
  }
  const std::vector<ViewPlace> places = ReadViewPlaces(request.views_like);
  return WriteViews(request, simulator, places.size(), [&](std::size_t i) {
    VirtualView view = views.RenderAt(places[i].stamp_ns, places[i].T_C_V);
    view.index = places[i].index;
    view.count = places[i].count;
    return std::vector<VirtualView>{view};
  });
}
#else
Json RunSimulateViews(const SimulateRequest& request) {
  ThrowInputError("{}: this deja_view was built without ROS",
                  (request.views_like.empty() ? request.views_for : request.views_like).string());
}
#endif

}  // namespace deja_view
