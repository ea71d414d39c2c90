#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"

#include <algorithm>
#include <fstream>
#include <functional>
#include <iostream>
#include <set>
#include <utility>

#include "bundle/bundle_command.hpp"
#include "common/interrupt.hpp"
#include "common/tool_figures.hpp"
#include "map/map_command.hpp"
#include "map/map_page.hpp"
#include "nerf/nerf_command.hpp"
#include "replay/replay.hpp"
#include "views/views_command.hpp"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

/// Of what the stages' figures are; another number where they change, so that none made before is
/// taken for one of today's.
constexpr int kFigures = 2;

/// Finished stages with what they were made from, in `stages.json`.
class Stages {
 public:
  Stages(const MapRequest& request, std::uint64_t input)
      : path_(request.out / "stages.json"), is_shown_(request.show_progress), key_(input) {
    std::ifstream file(path_);
    if (file) {
      finished_ = Json::parse(file, nullptr, false);
    }
    if (!finished_.is_object()) {
      finished_ = Json::object();
    }
  }

  /// Runs `make`, or takes what it gave before if the settings and all stages before are the same
  /// and `product` is there.
  Json Run(const std::string& name,
           const std::string& settings,
           const std::filesystem::path& product,
           const std::function<Json()>& make) {
    key_ = Hash64(fmt::format("{:016x}\n{}\n{}", key_, name, settings));
    const std::string key = fmt::format("{:016x}", key_);
    const auto before = finished_.find(name);
    if (before != finished_.end() && before->value("made_from", "") == key &&
        before->contains("figures") && std::filesystem::exists(product)) {
      Tell(name, "as it was");
      return (*before)["figures"];
    }
    Tell(name, "begins");
    is_begun_ = before != finished_.end() && before->value("made_from", "") == key;
    Forget(name);
    finished_[name] = {{"made_from", key}};
    Write();
    Json figures = Make(name, make);
    finished_[name]["figures"] = figures;
    Write();
    return figures;
  }

  /// Whether the running stage was begun before, with the same settings.
  bool is_begun() const { return is_begun_; }

 private:
  /// The stage and those after it, which were made of what it gave.
  void Forget(const std::string& name) {
    Json before = Json::object();
    for (const auto& stage : finished_.items()) {
      if (stage.key() == name) {
        break;
      }
      before[stage.key()] = stage.value();
    }
    finished_ = std::move(before);
  }

  static Json Make(const std::string& name, const std::function<Json()>& make) {
    try {
      return make();
    } catch (const InputError& e) {
      ThrowInputError("{}: {}", name, e.what());
    }
  }
  void Tell(const std::string& name, const std::string& what) const {
    if (is_shown_) {
      std::cerr << fmt::format("{}: {}\n", name, what);
    }
  }
  void Write() const {
    WriteFileAtomically(path_, [&](std::ostream& out) { out << finished_.dump(2) << "\n"; });
  }

  std::filesystem::path path_;
  bool is_shown_;
  std::uint64_t key_;
  Json finished_ = Json::object();
  bool is_begun_ = false;
};

/// One map in the making.
class MapMaker {
 public:
  explicit MapMaker(const MapRequest& request)
      : request_(request),
        start_(Clock::now()),
        stages_(request,
                Hash64(fmt::format("{} {} {} {} {}",
                                   kFigures,
                                   Hash64OfFile(request.bag),
                                   Hash64OfFile(request.camera),
                                   EnumToString(request.host.host),
                                   request.host.odometry_topic))) {}

  Json Make() {
    Json json;
    json["bundle"] = Adjust();
    images_ = json["bundle"]["images"].get<int>();
    json["field"] = Train();
    json["field_quality"] = Evaluate();
    interrupt_.Check();
    json["loops"] = CloseLoops();
    interrupt_.Check();
    json["views"] = Render();
    json["map"] = Save();
    interrupt_.Check();
    json["gain"] = Compare(json["loops"]["duration_s"].get<double>());
    json["cpu_s"] = CpuSeconds();
    json["wall_s"] = SecondsSince(start_);
    json["peak_rss_mb"] = PeakRssMb();
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
    const std::int64_t first_ns = result.keyframes.front().stamp_ns;
    const std::int64_t last_ns = result.keyframes.back().stamp_ns;
    return {{"keyframes", result.keyframes.size()},
            {"duration_s", 1e-9 * static_cast<double>(last_ns - first_ns)},
            {"places", result.places},
            {"loops", accepted},
            {"keyframes_with_loop", found.size()},
            {"views", result.views.kept},
            {"core_memory_mb", result.core_memory_mb}};
  }

  std::filesystem::path path(const std::string& name) const { return request_.out / name; }

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

  Json Adjust() {
    return stages_.Run("bundle", "", path("bundle/poses.txt"), [&] {
      BundleRequest bundle;
      bundle.host = request_.host;
      bundle.input.bag = request_.bag;
      bundle.input.camera = request_.camera;
      bundle.out = path("bundle");
      bundle.show_progress = request_.show_progress;
      const Json figures = RunBundle(bundle);
      if (figures.value("interrupted", false)) {
        throw Interrupted();
      }
      if (!std::filesystem::exists(path("bundle/poses.txt"))) {
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

  /// The images that were adjusted; of a long flight some 300, which show a hall often enough.
  NerfInput FieldInput() const {
    constexpr int kImages = 300;
    NerfInput input;
    input.bag = request_.bag;
    input.camera = request_.camera;
    input.poses = path("bundle/poses.txt");
    input.skip_missing = true;
    input.every = std::max(1, (images_ + kImages / 2) / kImages);
    return input;
  }

  Json Train() {
    // What describing and writing the views may take of what is left.
    constexpr double kTraining = 0.65;
    const std::string settings = request_.steps > 0 ? fmt::format("{} steps", request_.steps)
                                                    : fmt::format("{} s", request_.budget_s);
    return stages_.Run("field", settings, path("field.dvn"), [&] {
      NerfTrainRequest train;
      train.input = FieldInput();
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
      NerfEvalRequest eval;
      eval.input = FieldInput();
      eval.model = path("field.dvn");
      eval.pictures = path("pictures");
      eval.views = 8;
      eval.threads = request_.threads;
      eval.show_progress = request_.show_progress;
      return RunNerfEval(eval);
    });
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
  Stages stages_;
  int images_ = 0;
};

}  // namespace

Json RunMap(const MapRequest& request) {
  return MapMaker(request).Make();
}

}  // namespace deja_view
