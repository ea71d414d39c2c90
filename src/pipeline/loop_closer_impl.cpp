#include "loop_closer_impl.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/features/make_feature_extractor.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "stopwatch.hpp"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace deja_view {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

std::unique_ptr<FeatureExtractor> MakeViewExtractor(FeatureOptions features, int max_features) {
  features.brief.max_features = max_features;
  features.orb.max_features = max_features;
  return MakeFeatureExtractor(features);
}

LoopCloserOptions Validated(const LoopCloserOptions& options) {
  const std::vector<std::string> errors = options.Validate();
  if (!errors.empty()) {
    ThrowInputError("loop closer options: {}", fmt::join(errors, "; "));
  }
  return options;
}

}  // namespace

std::vector<std::string> LoopCloserOptions::Validate() const {
  std::vector<std::string> errors;
  const auto add = [&](const std::string& group, const std::vector<std::string>& more) {
    for (const std::string& error : more) {
      errors.push_back(group + "." + error);
    }
  };
  const auto require = [&](bool ok, const char* text) {
    if (!ok) {
      errors.emplace_back(text);
    }
  };
  add("features", features.Validate());
  add("verification", verification.Validate());
  add("consistency", consistency.Validate());
  add("place", place.Validate());
  add("scoring", scoring.Validate());
  add("pose_graph", pose_graph.Validate());
  add("views", views.Validate());
  require(candidates.min_age_s > 0, "candidates.min_age_s must be positive");
  require(candidates.retrieved >= 0, "candidates.retrieved must not be negative");
  require(candidates.island_gap_s >= 0, "candidates.island_gap_s must not be negative");
  require(candidates.max_loops >= 1, "candidates.max_loops must be at least 1");
  require(candidates.members_per_island >= 1, "candidates.members_per_island must be at least 1");
  require(candidates.max_verified >= 1, "candidates.max_verified must be at least 1");
  require(candidates.nearby >= 0, "candidates.nearby must not be negative");
  require(candidates.nearby_distance_m > 0, "candidates.nearby_distance_m must be positive");
  require(candidates.nearby_angle_deg > 0, "candidates.nearby_angle_deg must be positive");
  require(solve.every_loops >= 1, "solve.every_loops must be at least 1");
  require(solve.surprise > 0, "solve.surprise must be positive");
  require(solve.latency >= 1, "solve.latency must be at least 1");
  require(solve.nodes_per_latency >= 1, "solve.nodes_per_latency must be at least 1");
  require(map_spacing_m >= 0, "map_spacing_m must not be negative");
  require(map_spacing_deg > 0, "map_spacing_deg must be positive");
  require(max_speed_mps > 0, "max_speed_mps must be positive");
  require(max_point_error_px > 0, "max_point_error_px must be positive");
  require(max_point_depth_m > 0, "max_point_depth_m must be positive");
  require(point_sigma_floor > 0, "point_sigma_floor must be positive");
  require(point_track_sigma_px >= 0, "point_track_sigma_px must not be negative");
  require(point_sigma_max >= point_sigma_floor, "point_sigma_max must not be below the floor");
  return errors;
}

LoopCloser::Impl::Impl(const LoopCloserOptions& options_in,
                       std::shared_ptr<const Camera> camera_in,
                       const Rigid3& T_B_C_in,
                       std::shared_ptr<const Vocabulary> vocabulary_in,
                       SolveExecutor executor_in)
    : options(Validated(options_in)),
      camera(std::move(camera_in)),
      T_B_C(T_B_C_in),
      vocabulary(std::move(vocabulary_in)),
      executor(std::move(executor_in)),
      extractor(MakeFeatureExtractor(options.features)),
      verifier(options.verification, camera),
      graph(options.pose_graph),
      places(options.place, vocabulary),
      consistency(options.consistency),
      view_extractor_(MakeViewExtractor(options.features, options.views.max_features)),
      empty_index_bytes_(places.memory_bytes()) {
  if (options.scoring.is_on) {
    scored_places_.emplace(options.scoring, vocabulary);
  }
  if (vocabulary->descriptor_name() != extractor->DescriptorName()) {
    ThrowInputError(
        "features.kind: the vocabulary was made for '{}' descriptors, the options ask for '{}'",
        vocabulary->descriptor_name(),
        extractor->DescriptorName());
  }
}

LoopCloser::Impl::~Impl() {
  if (pending_solve_ && pending_solve_->done.valid()) {
    pending_solve_->done.wait();
  }
}

void LoopCloser::Impl::CheckInput(const KeyframeInput& input) const {
  if (input.image.type() != CV_8UC1 || input.image.cols != camera->width() ||
      input.image.rows != camera->height()) {
    ThrowInputError("keyframe {}: the image is {}x{} of type {}, expected {}x{} of 8 bits grey",
                    input.stamp_ns,
                    input.image.cols,
                    input.image.rows,
                    input.image.type(),
                    camera->width(),
                    camera->height());
  }
  if (!input.T_W_B.IsFinite() || std::abs(input.T_W_B.q.norm() - 1.0) > 1e-3) {
    ThrowInputError("keyframe {}: its pose is not a finite rigid transform", input.stamp_ns);
  }
}

bool LoopCloser::Impl::StartsSequence(const KeyframeInput& input) const {
  if (starts_sequence_ || input.starts_sequence) {
    return true;
  }
  const double dt = static_cast<double>(input.stamp_ns - keyframes.back().stamp_ns) * 1e-9;
  const double jump = (input.T_W_B.t - graph.nodes().back().T_W_B.t).norm();
  return dt <= 0 || jump > options.max_speed_mps * dt;
}

std::optional<Eigen::Vector3d> LoopCloser::Impl::LocatePoint(const TrackedPoint& point,
                                                             const Rigid3& T_C_W) const {
  if (!point.p_W.allFinite() || !point.pixel.allFinite()) {
    return std::nullopt;
  }
  const Eigen::Vector3d p_C = T_C_W * point.p_W;
  const Eigen::Vector2d pixel = point.pixel.cast<double>();
  const auto reprojected = camera->Project(p_C);
  if (p_C.norm() > options.max_point_depth_m || !camera->IsInImage(pixel) || !reprojected ||
      (*reprojected - pixel).norm() > options.max_point_error_px) {
    return std::nullopt;
  }
  return T_B_C * (p_C.norm() * camera->Unproject(pixel));
}

double LoopCloser::Impl::DepthSigma(const TrackedPoint& point, const Eigen::Vector3d& centre_W) {
  const std::size_t now = keyframes.size();
  const auto [it, is_new] = tracks_.try_emplace(point.feature_id, Track{centre_W, now});
  Track& track = it->second;
  if (!is_new && track.last_keyframe + 1 < now) {
    track.first_centre_W = centre_W;  // ids of a VIO that started anew
  }
  track.last_keyframe = now;
  const Eigen::Vector3d ray = point.p_W - centre_W;
  const double depth = std::max(1e-3, ray.norm());
  const double parallax = (track.first_centre_W - centre_W).cross(ray).norm() / (depth * depth);
  const double ratio =
      std::hypot(options.point_sigma_floor,
                 options.point_track_sigma_px / (camera->FocalLength() * std::max(1e-6, parallax)));
  return depth * std::min(options.point_sigma_max, ratio);
}

void LoopCloser::Impl::ExtractFeatures(const KeyframeInput& input, StoredKeyframe* keyframe) {
  KeyframeFeatures& f = keyframe->features;
  f.T_B_C = T_B_C;
  const Rigid3 T_C_W = (input.T_W_B * T_B_C).Inverse();
  std::vector<cv::Point2f> pixels;
  for (const TrackedPoint& point : input.points) {
    const auto p_B = LocatePoint(point, T_C_W);
    if (p_B) {
      f.points_B.push_back(p_B->cast<float>());
      f.point_pixels.push_back(point.pixel);
      f.point_depth_sigmas.push_back(
          static_cast<float>(DepthSigma(point, (input.T_W_B * T_B_C).t)));
      f.point_ids.push_back(point.feature_id);
      pixels.emplace_back(point.pixel.x(), point.pixel.y());
    }
  }
  for (auto it = tracks_.begin(); it != tracks_.end();) {
    it = it->second.last_keyframe < keyframes.size() ? tracks_.erase(it) : std::next(it);
  }
  Features features = extractor->Extract(input.image, pixels, &f.point_descriptors);
  f.keypoints.reserve(features.keypoints.size());
  for (const Keypoint& keypoint : features.keypoints) {
    f.keypoints.emplace_back(keypoint.x, keypoint.y);
  }
  f.descriptors = std::move(features.descriptors);
  f.descriptors.shrink_to_fit();
}

bool LoopCloser::Impl::IsNewPlace() const {
  if (options.map_spacing_m <= 0) {
    return true;
  }
  const int current = static_cast<int>(keyframes.size()) - 1;
  const NearbyPlace here = PlaceOf(current);
  const double min_cosine = std::cos(options.map_spacing_deg * kDegree);
  for (int i = 0; i < current; ++i) {
    const StoredKeyframe& k = keyframes[static_cast<std::size_t>(i)];
    if (!k.is_place || !graph.AreJoined(k.sequence, keyframes.back().sequence)) {
      continue;
    }
    const NearbyPlace place = PlaceOf(i);
    if ((place.position_M - here.position_M).norm() < options.map_spacing_m &&
        place.axis_M.dot(here.axis_M) > min_cosine) {
      return false;
    }
  }
  return true;
}

KeyframeReport LoopCloser::Impl::AddKeyframe(const KeyframeInput& input) {
  CheckInput(input);
  KeyframeReport report;
  Stopwatch watch;
  report.is_new_sequence = StartsSequence(input);
  if (report.is_new_sequence) {
    tracks_.clear();  // another world, and perhaps the same ids
  }
  StoredKeyframe keyframe;
  ExtractFeatures(input, &keyframe);
  report.times.features = watch.LapMs();
  keyframe.bow = vocabulary->Bag(keyframe.features.descriptors);
  if (scored_places_) {
    weighted_words_ = scored_places_->Weigh(keyframe.bow);
  }
  report.times.words = watch.LapMs();

  sequence += report.is_new_sequence ? 1 : 0;
  starts_sequence_ = false;
  keyframe.stamp_ns = input.stamp_ns;
  keyframe.sequence = sequence;
  keyframes.push_back(std::move(keyframe));
  report.index = graph.AddNode(sequence, input.T_W_B);
  report.sequence = sequence;

  watch.LapMs();
  TakeDueSolution(false, &report);
  report.times.graph = watch.LapMs();
  FindLoops(&report);
  watch.LapMs();
  StoredKeyframe& stored = keyframes.back();
  stamps_[stored.stamp_ns] = keyframes.size() - 1;
  if (options.add_places && IsNewPlace()) {
    stored.is_place = true;
    AddPlace(report.index, stored.bow, 0);
  } else {
    stored.features = KeyframeFeatures{};
    stored.features.T_B_C = T_B_C;
  }
  RememberWords();
  stored.bow = BowVector{};
  AttachWaitingViews(keyframes.size() - 1);
  report.times.words += watch.LapMs();
  ScheduleSolve();
  report.times.graph += watch.LapMs();
  return report;
}

void LoopCloser::Impl::ScheduleSolve() {
  const bool is_due = is_surprised_ || loops_since_solve_ >= options.solve.every_loops;
  if (pending_solve_ || !is_due) {
    return;
  }
  PendingSolve solve;
  solve.snapshot = std::make_shared<PoseGraph>(graph);
  solve.due =
      graph.size() + options.solve.latency - 1 + graph.size() / options.solve.nodes_per_latency;
  if (executor) {
    solve.done = executor([snapshot = solve.snapshot] { snapshot->Solve(); });
  } else {
    solve.snapshot->Solve();
  }
  pending_solve_ = std::move(solve);
  loops_since_solve_ = 0;
  is_surprised_ = false;
}

void LoopCloser::Impl::TakeDueSolution(bool wait_for_all, KeyframeReport* report) {
  if (!pending_solve_ || (!wait_for_all && graph.size() <= pending_solve_->due)) {
    return;
  }
  if (pending_solve_->done.valid()) {
    pending_solve_->done.get();
  }
  graph.TakeSolution(*pending_solve_->snapshot);
  pending_solve_.reset();
  if (report != nullptr) {
    report->graph_changed = true;
  }
}

void LoopCloser::Impl::OptimizeFully() {
  TakeDueSolution(true, nullptr);
  graph.Solve();
  loops_since_solve_ = 0;
  is_surprised_ = false;
}

bool LoopCloser::Impl::UpdateLoop(int current, const Rigid3& T_Bold_Bcurrent) {
  constexpr double kMaxChange =
      0.5;  // [m], [rad]: the refined pose is near the loop's or it is wrong
  if (!T_Bold_Bcurrent.IsFinite() || current < 0 || current >= static_cast<int>(keyframes.size())) {
    return false;
  }
  const int old = keyframes[static_cast<std::size_t>(current)].relocalised_old;
  for (auto it = accepted.rbegin(); it != accepted.rend(); ++it) {
    if (it->current == current && it->old == old) {
      const Rigid3 change = it->T_Bold_Bcurrent.Inverse() * T_Bold_Bcurrent;
      if (change.t.norm() > kMaxChange || RotationAngle(change.q) > kMaxChange) {
        return false;
      }
      it->T_Bold_Bcurrent = T_Bold_Bcurrent;
      return graph.UpdateLoop(it->old, it->current, T_Bold_Bcurrent);
    }
  }
  return false;
}

}  // namespace deja_view
