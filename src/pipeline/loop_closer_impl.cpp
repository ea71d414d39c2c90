#include "loop_closer_impl.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/features/make_feature_extractor.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace deja_view {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr double kLocalisedSeconds = 5.0;  // how long the corrected pose is the better guess

class Stopwatch {
 public:
  double LapMs() {
    const auto now = Clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

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

int LoopCloser::Impl::NewestOldEnough() const {
  const StoredKeyframe& current = keyframes.back();
  const auto min_age_ns = static_cast<std::int64_t>(options.candidates.min_age_s * 1e9);
  for (int i = static_cast<int>(keyframes.size()) - 2; i >= 0; --i) {
    const StoredKeyframe& k = keyframes[static_cast<std::size_t>(i)];
    if (k.sequence != current.sequence || current.stamp_ns - k.stamp_ns >= min_age_ns) {
      return i;
    }
  }
  return -1;
}

NearbyPlace LoopCloser::Impl::PlaceOf(int keyframe) const {
  const auto k = static_cast<std::size_t>(keyframe);
  const Rigid3 T_M_C = graph.nodes()[k].T_M_B() * keyframes[k].features.T_B_C;
  return {keyframe, T_M_C.t, T_M_C.q * Eigen::Vector3d::UnitZ()};
}

bool LoopCloser::Impl::IsLocalised() const {
  if (last_localised_ < 0) {
    return false;
  }
  const StoredKeyframe& last = keyframes[static_cast<std::size_t>(last_localised_)];
  const StoredKeyframe& current = keyframes.back();
  return last.sequence == current.sequence &&
         static_cast<double>(current.stamp_ns - last.stamp_ns) < kLocalisedSeconds * 1e9;
}

// A virtual camera is a place from which its keyframe knows the hall, too.
void LoopCloser::Impl::AddViewPlaces(int keyframe, std::vector<NearbyPlace>* around) const {
  const auto k = static_cast<std::size_t>(keyframe);
  for (const StoredView& view : keyframes[k].views) {
    const Rigid3 T_M_V = graph.nodes()[k].T_M_B() * keyframes[k].features.T_B_C * view.T_C_V;
    around->push_back({keyframe, T_M_V.t, T_M_V.q * Eigen::Vector3d::UnitZ()});
  }
}

// The most similar keyframes, each as similar as the most similar of its images.
std::vector<RetrievedPlace> LoopCloser::Impl::RetrieveFast(int newest) const {
  PlaceQuery query;
  query.max_results = options.candidates.retrieved;
  query.max_id = newest;
  query.min_score = options.candidates.min_score;
  query.best_per_id = true;
  std::vector<RetrievedPlace> retrieved;
  for (const PlaceMatch& match : places.Query(keyframes.back().bow, query)) {
    const StoredKeyframe& k = keyframes[static_cast<std::size_t>(match.id)];
    retrieved.push_back({match.id, match.score, k.sequence, k.stamp_ns});
  }
  return retrieved;
}

std::vector<RetrievedPlace> LoopCloser::Impl::Retrieve(int newest, KeyframeReport* report) const {
  if (scored_places_) {
    return RetrieveScored(newest, report);
  }
  std::vector<RetrievedPlace> retrieved = RetrieveFast(newest);
  if (!retrieved.empty()) {
    report->best_place = BestPlace{retrieved.front().keyframe, retrieved.front().score};
  }
  return retrieved;
}

std::vector<RetrievedPlace> LoopCloser::Impl::RetrieveScored(int newest,
                                                             KeyframeReport* report) const {
  const ScoringOptions& scoring = options.scoring;
  std::vector<RetrievedPlace> retrieved;
  for (const ScoredPlace& place : scored_places_->Query(
           weighted_words_, newest, static_cast<std::size_t>(scoring.neighbours))) {
    const StoredKeyframe& k = keyframes[static_cast<std::size_t>(place.id)];
    retrieved.push_back({place.id, place.score, k.sequence, k.stamp_ns});
  }
  const double own = OwnScore(weighted_words_);
  std::vector<RetrievedPlace> passed;
  for (const auto& island : GroupIntoIslands(retrieved, options.candidates.island_gap_s)) {
    std::vector<double> scores;
    for (const RetrievedPlace& place : island) {
      scores.push_back(place.score);
    }
    const double score = ThresholdScore(scores, scoring.threshold, own);
    if (!report->best_place || score > report->best_place->score) {
      report->best_place = BestPlace{island.front().keyframe, score};
    }
    if (score >= scoring.r) {
      passed.insert(passed.end(), island.begin(), island.end());
    }
  }
  return passed;
}

double LoopCloser::Impl::OwnScore(const WeightedBow& words) const {
  double best = 0;
  for (const WeightedBow& predecessor : predecessors_) {
    best = std::max(best, CosineSimilarity(words, predecessor));
  }
  return best;
}

void LoopCloser::Impl::RememberWords() {
  constexpr std::size_t kPredecessors = 3;
  if (scored_places_) {
    predecessors_.push_back(std::move(weighted_words_));
    if (predecessors_.size() > kPredecessors) {
      predecessors_.pop_front();
    }
  }
}

std::vector<Candidate> LoopCloser::Impl::FindCandidates(KeyframeReport* report) const {
  Stopwatch watch;
  const int newest = NewestOldEnough();
  if (newest < 0) {
    return {};
  }
  std::vector<RetrievedPlace> retrieved = Retrieve(newest, report);
  std::vector<NearbyPlace> around;
  for (int i = 0; i <= newest && options.candidates.nearby > 0; ++i) {
    const StoredKeyframe& k = keyframes[static_cast<std::size_t>(i)];
    if (k.is_place && graph.AreJoined(k.sequence, keyframes.back().sequence)) {
      around.push_back(PlaceOf(i));
      AddViewPlaces(i, &around);
    }
  }
  const auto nearby =
      CandidatesNearby(around, PlaceOf(static_cast<int>(keyframes.size()) - 1), options.candidates);
  auto candidates = MergeCandidates(CandidatesFromIslands(std::move(retrieved), options.candidates),
                                    nearby,
                                    IsLocalised(),
                                    options.candidates);
  report->times.query = watch.LapMs();
  return candidates;
}

LoopReport LoopCloser::Impl::VerifyCandidate(const Candidate& candidate,
                                             bool with_views,
                                             Verification* verification) const {
  const auto old = static_cast<std::size_t>(candidate.keyframe);
  const std::size_t current = keyframes.size() - 1;
  *verification = verifier.VerifyRig(keyframes[current].features,
                                     graph.nodes()[current].T_W_B.q,
                                     keyframes[old].features,
                                     graph.nodes()[old].T_W_B.q,
                                     with_views ? RigOf(old) : std::vector<RigCamera>());
  LoopReport report;
  report.is_virtual = with_views;
  report.current = static_cast<int>(current);
  report.old = candidate.keyframe;
  report.stamp_current_ns = keyframes[current].stamp_ns;
  report.stamp_old_ns = keyframes[old].stamp_ns;
  report.T_Bold_Bcurrent = verification->T_Bold_Bcurrent;
  report.covariance = verification->covariance;
  report.score = candidate.score;
  report.matches = verification->matches;
  report.inliers = verification->inliers;
  report.reason = verification->reason;
  return report;
}

Relocalisation LoopCloser::Impl::MakeRelocalisation(const LoopReport& loop,
                                                    const Verification& verification) const {
  Relocalisation result;
  result.old = loop.old;
  const auto old = static_cast<std::size_t>(loop.old);
  result.T_M_Bold = graph.nodes()[old].T_M_B();
  const KeyframeFeatures& current_features = keyframes.back().features;
  for (const PointMatch& match : verification.point_matches) {
    const Eigen::Vector2f& pixel =
        keyframes[old].features.keypoints[static_cast<std::size_t>(match.keypoint)];
    const Eigen::Vector3d bearing = camera->Unproject(pixel.cast<double>());
    if (bearing.z() > 1e-3) {
      result.points.push_back({current_features.point_ids[static_cast<std::size_t>(match.point)],
                               bearing.hnormalized()});
    }
  }
  return result;
}

LoopMatches LoopCloser::Impl::MakeMatches(const LoopReport& loop,
                                          const Verification& verification) const {
  LoopMatches matches{loop.stamp_current_ns, loop.stamp_old_ns, loop.is_virtual, {}};
  const std::vector<StoredView>& views = keyframes[static_cast<std::size_t>(loop.old)].views;
  for (const PixelMatch& match : verification.pixel_matches) {
    const int view =
        match.camera == 0 ? -1 : views[static_cast<std::size_t>(match.camera - 1)].index;
    matches.pairs.push_back({view, match.old_pixel, match.current_pixel});
  }
  return matches;
}

bool LoopCloser::Impl::TakeVerified(LoopReport loop,
                                    const Verification& verification,
                                    KeyframeReport* report) {
  PoseGraphLoop edge;
  edge.from = loop.old;
  edge.to = loop.current;
  edge.T_from_to = loop.T_Bold_Bcurrent;
  edge.covariance = loop.covariance;
  reports.push_back(loop);
  const auto believed = consistency.Add(edge, static_cast<int>(reports.size()) - 1, graph);
  const bool is_believed = consistency.last_state() == LoopConsistency::State::kAccepted;
  if (!is_believed) {
    loop.reason = consistency.last_state() == LoopConsistency::State::kImplausible
                      ? RejectReason::kImplausible
                      : RejectReason::kInconsistent;
    report->loops.push_back(loop);
  }
  report->reason = loop.reason;
  Believe(believed, report);
  if (is_believed) {
    report->matches.push_back(MakeMatches(loop, verification));
  }
  // The VIO takes pixels of the old real image: what virtual views alone show is of no use to it.
  if (is_believed && !loop.is_virtual && !report->relocalisation) {
    report->relocalisation = MakeRelocalisation(loop, verification);
    keyframes.back().relocalised_old = loop.old;
  }
  return is_believed;
}

// The real images of all candidates first: a rig costs several times as much, and is of use only
// where they don't do.
void LoopCloser::Impl::FindLoops(KeyframeReport* report) {
  const std::vector<Candidate> candidates = FindCandidates(report);
  Stopwatch watch;
  int found = 0;
  int rigs = 0;
  std::vector<std::pair<Candidate, LoopReport>> failed;
  for (const Candidate& candidate : candidates) {
    if (found >= options.candidates.max_loops) {
      break;
    }
    Verification verification;
    const LoopReport loop = VerifyCandidate(candidate, false, &verification);
    if (loop.reason == RejectReason::kNone) {
      found += TakeVerified(loop, verification, report) ? 1 : 0;
    } else {
      failed.emplace_back(candidate, loop);
    }
  }
  for (auto& [candidate, loop] : failed) {
    const bool has_views = !keyframes[static_cast<std::size_t>(candidate.keyframe)].views.empty();
    Verification verification;
    if (has_views && found < options.candidates.max_loops && rigs < options.views.max_tried) {
      ++rigs;
      loop = VerifyCandidate(candidate, true, &verification);
    }
    if (loop.reason == RejectReason::kNone) {
      found += TakeVerified(loop, verification, report) ? 1 : 0;
    } else {
      report->reason = loop.reason;
      report->loops.push_back(loop);
    }
  }
  if (found > 0) {
    report->reason = RejectReason::kNone;
  }
  report->times.verification = watch.LapMs();
}

void LoopCloser::Impl::Believe(const std::vector<LoopConsistency::Entry>& entries,
                               KeyframeReport* report) {
  for (const LoopConsistency::Entry& entry : entries) {
    const bool was_joined =
        graph.AreJoined(keyframes[static_cast<std::size_t>(entry.loop.from)].sequence,
                        keyframes[static_cast<std::size_t>(entry.loop.to)].sequence);
    graph.AddLoop(entry.loop);
    LoopReport loop = reports[static_cast<std::size_t>(entry.tag)];
    loop.reason = RejectReason::kNone;
    accepted.push_back(loop);
    report->loops.push_back(loop);
    ++loops_since_solve_;
    is_surprised_ =
        is_surprised_ || !was_joined ||
        graph.SquaredError(entry.loop) > options.solve.surprise * options.solve.surprise;
    report->graph_changed = report->graph_changed || !was_joined;
    last_localised_ = std::max(last_localised_, entry.loop.to);
  }
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
