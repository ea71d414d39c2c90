#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"
#include "deja_view/io/tum.hpp"

#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bundle/bundle_command.hpp"
#include "common/interrupt.hpp"
#include "common/pose_input.hpp"
#include "common/tool_figures.hpp"
#include "map/map_command.hpp"
#include "map/map_flights.hpp"
#include "map/map_input.hpp"
#include "map/map_page.hpp"
#include "map/map_stages.hpp"
#include "nerf/nerf_command.hpp"
#include "replay/replay.hpp"
#include "views/views_command.hpp"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

std::vector<MappedFlight> ReadMapped(const MapRequest& request) {
  return request.add.empty() ? std::vector<MappedFlight>() : ReadMappedFlights(request.add);
}

/// One map in the making.
class MapMaker {
 public:
  explicit MapMaker(const MapRequest& request)
      : request_(request),
        start_(Clock::now()),
        mapped_(ReadMapped(request)),
        stages_(request.out, HashOfMapInput(request), request.show_progress) {}

  Json Make() {
    Json json;
    json["bundle"] = Adjust();
    images_ = json["bundle"]["images"].get<int>();
    if (is_added()) {
      json["loops"] = Join();
      interrupt_.Check();
    }
    json["field"] = Train();
    json["field_quality"] = Evaluate();
    interrupt_.Check();
    if (!is_added()) {
      json["loops"] = CloseLoops();
      interrupt_.Check();
    }
    json["views"] = Render();
    json["map"] = Save();
    interrupt_.Check();
    json["gain"] = Compare(json["loops"]["duration_s"].get<double>());
    json["cpu_s"] = CpuSeconds();
    json["wall_s"] = SecondsSince(start_);
    json["peak_rss_mb"] = PeakRssMb();
    json["flights"] = Flights();
    json["advice"] = MapAdvice(json);
    WriteFileAtomically(request_.out / "map.json",
                        [&](std::ostream& out) { out << json.dump(2) << "\n"; });
    WriteMapPage(request_.out, json);
    return json;
  }

 private:
  ReplayRequest Replay() const {
    ReplayRequest replay;
    replay.host = request_.host;
    replay.bag = request_.bag;
    replay.camera = request_.camera;
    replay.load_map = request_.add;
    replay.overrides = request_.overrides;
    replay.show_progress = request_.show_progress;
    return replay;
  }

  static Json Figures(const ReplayResult& result) {
    std::set<int> found;
    int accepted = 0;
    for (const LoopReport& loop : result.loops) {
      if (loop.accepted()) {
        ++accepted;
        found.insert(loop.current);
      }
    }
    const auto known = static_cast<std::size_t>(result.map_keyframes);
    const std::int64_t first_ns = result.keyframes[known].stamp_ns;
    const std::int64_t last_ns = result.keyframes.back().stamp_ns;
    return {{"keyframes", result.keyframes.size() - known},
            {"duration_s", 1e-9 * static_cast<double>(last_ns - first_ns)},
            {"places", result.places},
            {"loops", accepted},
            {"keyframes_with_loop", found.size()},
            {"views", result.views.kept},
            {"core_memory_mb", result.core_memory_mb}};
  }

  bool is_added() const { return !request_.add.empty(); }
  std::filesystem::path path(const std::string& name) const { return request_.out / name; }
  /// Of the flight in its own odometry's world.
  std::string AdjustedFolder() const { return is_added() ? "adjusted" : "bundle"; }

  /// With features alone, unless the flight with its views was asked for.
  std::filesystem::path ViewsBag() const {
    return request_.bag_out.empty() ? path("views.bag") : request_.bag_out;
  }

  Json CloseLoops() {
    const std::string settings = fmt::format("{}", fmt::join(request_.overrides, "\n"));
    return stages_.Run("loops", settings, path("flight/places.txt"), [&] {
      ReplayRequest replay = Replay();
      replay.use_virtual_views = false;
      replay.out = path("flight");
      return Figures(RunReplay(replay));
    });
  }

  /// Finds the map's places, and brings the adjusted poses to the field's frame by them.
  Json Join() {
    const std::string settings = fmt::format("{}", fmt::join(request_.overrides, "\n"));
    return stages_.Run("loops", settings, path("bundle/poses.txt"), [&] {
      ReplayRequest replay = Replay();
      replay.out = path("flight");
      const ReplayResult result = RunReplay(replay);
      WriteTum(path("flight/places.txt"), OwnPlaces(result));
      const std::string what =
          fmt::format("{}, against {}", request_.bag.string(), request_.add.string());
      const JoinedFlight joined =
          JoinFlight(result, mapped_, ReadTum(path("adjusted/poses.txt")), what);
      WriteTum(path("bundle/poses.txt"), joined.T_F_B);
      Json figures = Figures(result);
      figures["join"] = ToJson(joined.fit);
      return figures;
    });
  }

  static Trajectory OwnPlaces(const ReplayResult& result) {
    Trajectory places;
    for (const KeyframeInfo& keyframe : result.keyframes) {
      if (keyframe.index >= result.map_keyframes && keyframe.is_place) {
        places.stamps_ns.push_back(keyframe.stamp_ns);
        places.poses.push_back(keyframe.T_M_B);
      }
    }
    return places;
  }

  /// What the map is made of, with the poses of flights before beside its own.
  Json Flights() const {
    Json flights = Json::array();
    for (MappedFlight flight : mapped_) {
      const auto poses = path(fmt::format("flights/{}.txt", flights.size()));
      WriteTum(poses, ReadTum(flight.poses));
      flight.poses = poses;
      flights.push_back(ToJson(flight, request_.out));
    }
    flights.push_back(ToJson(Flight(), request_.out));
    return flights;
  }

  Json Adjust() {
    return stages_.Run("bundle", "", path(AdjustedFolder() + "/poses.txt"), [&] {
      BundleRequest bundle;
      bundle.host = request_.host;
      bundle.input.bag = request_.bag;
      bundle.input.camera = request_.camera;
      bundle.out = path(AdjustedFolder());
      bundle.show_progress = request_.show_progress;
      const Json figures = RunBundle(bundle);
      if (figures.value("interrupted", false)) {
        throw Interrupted();
      }
      if (!std::filesystem::exists(bundle.out / "poses.txt")) {
        ThrowInputError("{}: stamps that go back: a map is made of one flight",
                        request_.bag.string());
      }
      return Json{{"images", figures["images"]},
                  {"weak_images", figures["weak_images"]},
                  {"points", figures["points"]},
                  {"median_px", figures["median_px"]},
                  {"mean_shift_m", figures["mean_shift_m"]}};
    });
  }

  /// Of the images that were adjusted the field takes some 300, which show a hall often enough.
  MappedFlight Flight() const {
    constexpr int kImages = 300;
    return {request_.bag,
            request_.camera,
            path("bundle/poses.txt"),
            std::max(1, (images_ + kImages / 2) / kImages)};
  }

  Json Train() {
    // What describing and writing the views may take of what is left.
    constexpr double kTraining = 0.65;
    const std::string settings = request_.steps > 0 ? fmt::format("{} steps", request_.steps)
                                                    : fmt::format("{} s", request_.budget_s);
    return stages_.Run("field", settings, path("field.dvn"), [&] {
      NerfTrainRequest train;
      train.input = Flight().Images();
      for (const MappedFlight& flight : mapped_) {
        train.more.push_back(flight.Images());
      }
      if (is_added()) {
        train.start_from = request_.add / "field.dvn";
      }
      train.budget_s = std::max(30.0, kTraining * (request_.budget_s - SecondsSince(start_)));
      train.steps = request_.steps;
      train.threads = request_.threads;
      train.out = path("field.dvn");
      train.show_progress = request_.show_progress;
      if (stages_.is_begun() && std::filesystem::exists(train.out) &&
          RunNerfInfo(train.out).value("trained_share", 1.0) < 1) {
        train.resume = train.out;
      }
      if (train.resume.empty()) {
        std::filesystem::remove(train.out);  // or a kill now would leave another's to go on with
      }
      Json figures = RunNerfTrain(train);
      figures["resumed"] = !train.resume.empty();
      if (figures["interrupted"].get<bool>()) {
        throw Interrupted();
      }
      return figures;
    });
  }

  Json Evaluate() {
    return stages_.Run("field_quality", "", path("field.dvn"), [&] {
      Json figures = Evaluate(path("field.dvn"), Flight(), path("pictures"));
      if (is_added()) {
        figures["before"] = Evaluate(request_.add / "field.dvn", Flight(), {});
        figures["others"] = Json::array();
      }
      for (const MappedFlight& flight : mapped_) {
        figures["others"].push_back(Evaluate(path("field.dvn"), flight, {}));
      }
      return figures;
    });
  }

  Json Evaluate(const std::filesystem::path& model,
                const MappedFlight& flight,
                const std::filesystem::path& pictures) const {
    NerfEvalRequest eval;
    eval.input = flight.Images();
    eval.model = model;
    eval.pictures = pictures;
    eval.views = 8;
    eval.threads = request_.threads;
    eval.show_progress = request_.show_progress;
    return RunNerfEval(eval);
  }

  Json Render() {
    const bool is_file = std::filesystem::is_regular_file(request_.preset);
    const std::string preset =
        is_file ? fmt::format("{:016x}", Hash64OfFile(request_.preset)) : request_.preset;
    const bool are_apart = request_.bag_out.empty();
    const std::string settings = fmt::format(
        "{} {}\n{}", preset, request_.bag_out.string(), fmt::join(request_.view_overrides, "\n"));
    return stages_.Run("views", settings, ViewsBag(), [&] {
      ViewsRenderRequest views;
      views.input.flight.bag = request_.bag;
      views.input.flight.camera = request_.camera;
      views.input.poses = path("bundle/poses.txt");
      views.input.align_to = "off";  // they are in the odometry's world, however far that drifted
      views.input.model = path("field.dvn");
      views.input.preset = request_.preset;
      views.input.overrides = request_.view_overrides;
      views.input.sources = "images";  // those of the places, whoever made them keyframes
      views.input.places = path("flight/places.txt");
      views.input.threads = request_.threads;
      views.input.show_progress = request_.show_progress;
      views.content = are_apart ? "features" : "both";
      views.views_only = are_apart;
      views.out = ViewsBag();
      return RunViewsRender(views);
    });
  }

  Json Save() {
    return stages_.Run("map", "", path("map.dvm"), [&] {
      ReplayRequest replay = Replay();
      replay.virtual_bag = ViewsBag();
      replay.save_map = request_.out;
      replay.out = path("flight_with_views");
      return Figures(RunReplay(replay));
    });
  }

  /// What the views are worth to another flight: the second half of this one, on a map of the
  /// first.
  Json Compare(double duration_s) {
    return stages_.Run("gain", "", path("first_half/map.dvm"), [&] {
      ReplayRequest half = Replay();
      half.duration_s = duration_s / 2;
      half.virtual_bag = ViewsBag();
      half.save_map = path("first_half");
      Json figures = {{"places", RunReplay(half).places}};
      for (const bool with_views : {false, true}) {
        ReplayRequest other = Replay();
        other.start_s = duration_s / 2;
        other.load_map = path("first_half");
        other.overrides.emplace_back("add_places=false");
        other.use_virtual_views = with_views;
        const ReplayResult result = RunReplay(other);
        figures["keyframes"] = result.keyframes.size() - result.map_keyframes;
        figures[with_views ? "found_with_views" : "found_without_views"] = FoundInMap(result);
      }
      return figures;
    });
  }

  /// Keyframes of the flight that found a place of the map.
  static std::size_t FoundInMap(const ReplayResult& result) {
    std::set<int> found;
    for (const LoopReport& loop : result.loops) {
      if (loop.accepted() && loop.old < result.map_keyframes) {
        found.insert(loop.current);
      }
    }
    return found.size();
  }

  Interrupt interrupt_;  // before any stage starts threads
  const MapRequest& request_;
  Clock::time_point start_;
  std::vector<MappedFlight> mapped_;  ///< of the map that is added to
  MapStages stages_;
  int images_ = 0;
};

}  // namespace

Json RunMap(const MapRequest& request) {
  std::error_code error;
  if (!request.add.empty() && std::filesystem::equivalent(request.add, request.out, error)) {
    ThrowInputError("--out {}: expected another directory than that of --add, which is kept",
                    request.out.string());
  }
  return MapMaker(request).Make();
}

}  // namespace deja_view
