#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/bundle/bundle_features.hpp"
#include "deja_view/features/brief_extractor.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/ros/bag/bag_replay.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "bundle/bundle_command.hpp"
#include "common/interrupt.hpp"
#include "common/tool_figures.hpp"
#include "replay/replay.hpp"

namespace deja_view {
namespace {

/// Where a flight's keyframes are with its loops closed.
struct ClosedLoops {
  std::map<std::int64_t, KeyframeInfo> keyframes;             ///< by stamp
  std::vector<std::pair<std::int64_t, std::int64_t>> stamps;  ///< old and current, of loops
  std::vector<Rigid3> T_old_current;                          ///< of the loops
};

ClosedLoops CloseLoops(const BundleRequest& request) {
  ReplayRequest replay;
  replay.host = request.host;
  replay.bag = request.input.bag;
  replay.camera = request.input.camera;
  replay.vocabulary = request.vocabulary;
  replay.use_virtual_views = false;
  replay.show_progress = request.show_progress;
  const ReplayResult result = RunReplay(replay);
  ClosedLoops closed;
  for (const KeyframeInfo& keyframe : result.keyframes) {
    closed.keyframes[keyframe.stamp_ns] = keyframe;
  }
  for (const LoopReport& loop : result.loops) {
    if (loop.accepted()) {
      closed.stamps.emplace_back(loop.stamp_old_ns, loop.stamp_current_ns);
      closed.T_old_current.push_back(loop.T_Bold_Bcurrent);
    }
  }
  return closed;
}

/// Takes keyframes as they come.
class FlightReader {
 public:
  FlightReader(const BundleRequest& request,
               const BundleToolOptions& options,
               const Interrupt& interrupt)
      : request_(request),
        interrupt_(interrupt),
        extractor_(options.features),
        vins_(ReadVinsConfig(request.input.camera)) {
    input.problem.cameras.push_back({vins_.camera, vins_.T_B_C, 0.0});
  }

  void Read() {
    ReplayCallbacks callbacks;
    callbacks.on_extrinsic = [this](const Rigid3& T_B_C) {
      input.problem.cameras.front().T_B_C = T_B_C;
    };
    callbacks.on_keyframe = [this](const KeyframeInput& keyframe) { Add(keyframe); };
    callbacks.on_problem = [this](const std::string& what) { input.warnings.push_back(what); };
    Progress progress("describing", "messages", 0);
    const auto show = [&](std::int64_t done, std::int64_t total) {
      interrupt_.Check();
      progress.SetTotal(static_cast<std::size_t>(total));
      if (request_.show_progress) {
        progress.Update(static_cast<std::size_t>(done));
      }
    };
    callbacks.on_progress = show;
    ReplayBag(request_.input.bag,
              {},
              request_.host.Topics(vins_, request_.input.camera),
              {},
              callbacks,
              request_.host.FrontEnd(vins_, {}),
              request_.host.Poses(vins_, request_.input.bag));
  }

  BundleInput input;
  std::vector<Rigid3> T_W_B_vio;
  std::vector<int> sequences;

 private:
  void Add(const KeyframeInput& keyframe) {
    if (keyframe.starts_sequence && !sequences.empty()) {
      ++sequence_;
    }
    std::vector<BundleTrackedPixel> tracked;
    for (const TrackedPoint& point : keyframe.points) {
      if (point.pixel.allFinite()) {
        // Ids begin anew with a VIO that starts anew.
        const std::int64_t id =
            point.feature_id < 0 ? -1
                                 : point.feature_id + (static_cast<std::int64_t>(sequence_) << 40);
        tracked.push_back({point.pixel, id});
      }
    }
    BundleImage image;
    image.stamp_ns = keyframe.stamp_ns;
    image.T_W_B = keyframe.T_W_B;
    DescribeImage(keyframe.image, tracked, extractor_, &image);
    input.problem.images.push_back(std::move(image));
    T_W_B_vio.push_back(keyframe.T_W_B);
    sequences.push_back(sequence_);
    input.names.push_back(std::to_string(keyframe.stamp_ns) + ".png");
    if (request_.write_images) {
      WritePng(request_.out / "colmap" / "images" / input.names.back(), keyframe.image);
    }
  }

  const BundleRequest& request_;
  const Interrupt& interrupt_;
  BriefExtractor extractor_;
  VinsConfig vins_;
  int sequence_ = 0;
};

void ApplyLoops(const ClosedLoops& closed, BundleProblem* problem, std::vector<int>* sequences) {
  std::map<std::int64_t, int> index;
  for (std::size_t i = 0; i < problem->images.size(); ++i) {
    BundleImage& image = problem->images[i];
    index[image.stamp_ns] = static_cast<int>(i);
    const auto keyframe = closed.keyframes.find(image.stamp_ns);
    if (keyframe != closed.keyframes.end()) {
      image.T_W_B = keyframe->second.T_M_B;
      (*sequences)[i] = keyframe->second.sequence;
    }
  }
  for (std::size_t i = 0; i < closed.stamps.size(); ++i) {
    const auto from = index.find(closed.stamps[i].first);
    const auto to = index.find(closed.stamps[i].second);
    if (from != index.end() && to != index.end()) {
      problem->loops.push_back({from->second, to->second, closed.T_old_current[i]});
    }
  }
}

}  // namespace

BundleInput ReadFlight(const BundleRequest& request,
                       const BundleToolOptions& options,
                       const Interrupt& interrupt) {
  const std::optional<ClosedLoops> closed =
      request.use_loops ? std::make_optional(CloseLoops(request)) : std::nullopt;
  FlightReader reader(request, options, interrupt);
  reader.Read();
  BundleProblem& problem = reader.input.problem;
  if (closed) {
    ApplyLoops(*closed, &problem, &reader.sequences);
  }
  SetVelocities(reader.sequences, &problem);
  AddOdometryPriors(options.priors, reader.T_W_B_vio, reader.sequences, &problem);
  return std::move(reader.input);
}

}  // namespace deja_view
