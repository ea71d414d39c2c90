#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/camera/camera_parameters.hpp"
#include "deja_view/io/colmap.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/io/tum.hpp"

#include <iostream>
#include <optional>

#include "bundle/bundle_command.hpp"
#include "common/interrupt.hpp"
#include "common/tool_figures.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const BundleCamera& camera) {
  const CameraParameters p = DescribeCamera(*camera.camera);
  const Rigid3& T = camera.T_B_C;
  return {{"model", p.model},
          {"projection", p.projection},
          {"distortion", p.distortion},
          {"t_B_C_m", {T.t.x(), T.t.y(), T.t.z()}},
          {"q_B_C_xyzw", {T.q.x(), T.q.y(), T.q.z(), T.q.w()}},
          {"time_offset_s", camera.time_offset_s}};
}

Json ToJson(const BundleRound& r) {
  return {{"error_px", r.error_px},
          {"pairs", r.pairs},
          {"matches", r.matches},
          {"tracks", r.tracks},
          {"points", r.points},
          {"adjusted_points", r.adjusted_points},
          {"observations", r.observations},
          {"iterations", r.iterations},
          {"rms_before_px", r.rms_before_px},
          {"rms_after_px", r.rms_after_px},
          {"matching_s", r.matching_s},
          {"solving_s", r.solving_s}};
}

Json ToJson(const BundleSummary& summary) {
  Json rounds = Json::array();
  for (const BundleRound& round : summary.rounds) {
    rounds.push_back(ToJson(round));
  }
  return {{"images", summary.images},
          {"weak_images", summary.weak_images},
          {"points", summary.points},
          {"observations", summary.observations},
          {"observations_per_point", summary.mean_track},
          {"rms_px", summary.rms_px},
          {"median_px", summary.median_px},
          {"mean_shift_m", summary.mean_shift_m},
          {"largest_shift_m", summary.largest_shift_m},
          {"rounds", rounds}};
}

ColmapModel ToColmap(const BundleInput& input) {
  const BundleProblem& problem = input.problem;
  ColmapModel model;
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
    model.cameras[static_cast<std::uint32_t>(i + 1)] = problem.cameras[i].camera;
  }
  for (std::size_t i = 0; i < problem.images.size(); ++i) {
    const BundleImage& image = problem.images[i];
    model.images.push_back({static_cast<std::uint32_t>(i + 1),
                            static_cast<std::uint32_t>(image.camera + 1),
                            input.names[i],
                            problem.CameraPose(static_cast<int>(i)),
                            {}});
  }
  for (std::size_t p = 0; p < problem.points.size(); ++p) {
    const BundlePoint& point = problem.points[p];
    model.points[p + 1] = {point.p_W, point.rms_px, point.observations.size()};
    for (const BundleObservation& o : point.observations) {
      const auto i = static_cast<std::size_t>(o.image);
      model.images[i].observations.push_back(
          {problem.images[i].keypoints[static_cast<std::size_t>(o.keypoint)].cast<double>(),
           p + 1});
    }
  }
  return model;
}

/// With progress, until it is done or Ctrl-C.
BundleSummary Adjust(const BundleRequest& request,
                     const BundleOptions& options,
                     const Interrupt& interrupt,
                     BundleProblem* problem) {
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("adjusting", "%", 100);
  }
  std::string note = "matching";
  const auto on_round = [&](const BundleRound& round) {
    note = fmt::format("within {:.1f} px: {} points, RMS {:.3f} -> {:.3f} px",
                       round.error_px,
                       round.points,
                       round.rms_before_px,
                       round.rms_after_px);
  };
  const BundleSummary summary = AdjustBundle(options, problem, on_round, [&](double share) {
    if (progress) {
      progress->Update(static_cast<std::size_t>(100 * share), note);
    }
    return !interrupt.HasCome();
  });
  if (progress) {
    const auto percent = 100 * summary.rounds.size() / static_cast<std::size_t>(options.rounds);
    progress->Finish(percent, note);
    std::cerr << summary.ToString() << "\n";
  }
  return summary;
}

void WritePoses(const std::filesystem::path& path, const BundleProblem& problem) {
  Trajectory trajectory;
  for (const BundleImage& image : problem.images) {
    if (!trajectory.empty() && image.stamp_ns <= trajectory.stamps_ns.back()) {
      return;  // no stamps, or several cameras or sequences: the model has the poses
    }
    trajectory.stamps_ns.push_back(image.stamp_ns);
    trajectory.poses.push_back(image.T_W_B);
  }
  WriteTum(path, trajectory);
}

}  // namespace

bool BundleRequest::IsFlight() const {
  return !input.bag.empty() && input.poses.empty() && input.pose_topic.empty();
}

Json RunBundle(const BundleRequest& request) {
  BundleToolOptions options;
  ReadOptions(request.config, request.overrides, &options);
  for (const std::string& part : request.refine) {
    OverrideOption(fmt::format("bundle.refine.{}=true", part), &options);
  }
  const Interrupt interrupt;
  BundleInput input = request.IsFlight() ? ReadFlight(request, options, interrupt)
                                         : ReadPosedImages(request, options);
  const double read_cpu_s = CpuSeconds();
  Json cameras_before = Json::array();
  for (const BundleCamera& camera : input.problem.cameras) {
    cameras_before.push_back(ToJson(camera));
  }
  const BundleSummary summary = Adjust(request, options.bundle, interrupt, &input.problem);
  if (summary.was_stopped && summary.rounds.empty()) {
    throw Interrupted();
  }
  if (!summary.is_usable()) {
    ThrowInputError("the images can't be adjusted: {}", summary.obstacle);
  }
  Json json = ToJson(summary);
  json["interrupted"] = summary.was_stopped;
  json["cameras_before"] = cameras_before;
  json["cameras"] = Json::array();
  for (const BundleCamera& camera : input.problem.cameras) {
    json["cameras"].push_back(ToJson(camera));
  }
  json["warnings"] = input.warnings;
  json["read_cpu_s"] = read_cpu_s;
  json["cpu_s"] = CpuSeconds();
  json["peak_rss_mb"] = PeakRssMb();
  WritePoses(request.out / "poses.txt", input.problem);
  WriteColmapModel(ToColmap(input), request.out / "colmap");
  WriteFileAtomically(request.out / "bundle.json",
                      [&](std::ostream& out) { out << json.dump(2) << "\n"; });
  return json;
}

}  // namespace deja_view
