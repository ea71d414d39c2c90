#include "loop_closer_impl.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/features/make_feature_extractor.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "map_io.hpp"
#include "own_points.hpp"
#include "step_timer.hpp"
#include <Eigen/Cholesky>

namespace deja_view {
namespace {

LoopCloserOptions Validated(const LoopCloserOptions& options) {
  RejectAny(options.Validate(), "loop closer options");
  return options;
}

/// What became of a keyframe: the first of its own loops that was accepted, else the last that was
/// not.
RejectReason ReasonOf(const KeyframeReport& report) {
  RejectReason reason = RejectReason::kNoCandidate;
  for (const LoopReport& loop : report.loops) {
    if (loop.current == report.index) {
      reason = loop.reason;
      if (loop.accepted()) {
        break;
      }
    }
  }
  return reason;
}

}  // namespace

LoopCloserImpl::LoopCloserImpl(const LoopCloserOptions& options,
                               std::shared_ptr<const Camera> camera,
                               const Rigid3& T_B_C,
                               std::shared_ptr<const Vocabulary> vocabulary,
                               SolveExecutor executor)
    : options_(Validated(options)),
      camera_(std::move(camera)),
      T_B_C_(T_B_C),
      extractor_(MakeFeatureExtractor(options.features)),
      verifier_(options.verification, camera_),
      tracks_(options.track_depths, camera_),
      stereo_(options.motion_stereo, camera_),
      policy_(options.map_spacing_m, options.map_spacing_deg, options.map_cover, camera_),
      places_(options.place, options.scoring, options.candidates, vocabulary),
      shelf_(options.views, options.features, &verifier_, &places_),
      keyframes_(options.pose_graph),
      loops_(options.consistency),
      solve_(options.solve, std::move(executor)),
      measurements_(options.solve.measurement_latency) {
  if (vocabulary->descriptor_name() != extractor_->DescriptorName()) {
    ThrowInputError(
        "features.kind: the vocabulary was made for '{}' descriptors, the options ask for '{}'",
        vocabulary->descriptor_name(),
        extractor_->DescriptorName());
  }
}

KeyframeReport LoopCloserImpl::AddKeyframe(const KeyframeInput& input) {
  CheckInput(input);
  KeyframeReport report;
  report.is_new_sequence = StartsSequence(input);
  NewKeyframe current = Describe(input, report.is_new_sequence, &report.times);
  Append(input, &report);
  Triangulate(&current, &report.times);
  Refine(measurements_.TakeDue(report.index));
  TakeDueSolution(&report);
  const std::vector<Candidate> candidates = FindCandidates(current, &report);
  FindLoops(candidates, current, &report);
  report.reason = ReasonOf(report);
  Explain(candidates, current, &report);
  BecomePlace(std::move(current), &report.times);
  StartDueSolve(&report.times);
  return report;
}

void LoopCloserImpl::CheckInput(const KeyframeInput& input) const {
  if (input.image.type() != CV_8UC1 || input.image.cols != camera_->width() ||
      input.image.rows != camera_->height()) {
    ThrowInputError("keyframe {}: the image is {}x{} of type {}, expected {}x{} of 8 bits grey",
                    input.stamp_ns,
                    input.image.cols,
                    input.image.rows,
                    input.image.type(),
                    camera_->width(),
                    camera_->height());
  }
  if (!input.T_W_B.IsFinite() || std::abs(input.T_W_B.q.norm() - 1.0) > 1e-3) {
    ThrowInputError("keyframe {}: its pose is not a finite rigid transform", input.stamp_ns);
  }
}

bool LoopCloserImpl::StartsSequence(const KeyframeInput& input) const {
  if (starts_sequence_ || input.starts_sequence) {
    return true;
  }
  const int last = keyframes_.newest();
  const double dt = static_cast<double>(input.stamp_ns - keyframes_[last].stamp_ns) * 1e-9;
  const double jump = (input.T_W_B.t - keyframes_.node(last).T_W_B.t).norm();
  return dt <= 0 || jump > options_.max_speed_mps * dt;
}

LoopCloserImpl::NewKeyframe LoopCloserImpl::Describe(const KeyframeInput& input,
                                                     bool is_new_sequence,
                                                     KeyframeTimes* times) {
  NewKeyframe current;
  KeyframeFeatures& f = current.features;
  {
    const StepTimer timer(&times->features);
    if (is_new_sequence) {
      tracks_.Clear();
      stereo_.Restart();
    }
    f.T_B_C = T_B_C_;
    std::vector<cv::Point2f> pixels;
    for (const LocatedPoint& point : tracks_.Locate(input.points, input.T_W_B, T_B_C_)) {
      f.points_B.push_back(point.p_B);
      f.point_pixels.push_back(point.pixel);
      f.point_depth_sigmas.push_back(point.depth_sigma);
      f.point_ids.push_back(point.id);
      pixels.emplace_back(point.pixel.x(), point.pixel.y());
    }
    const VerticalField vertical =
        MakeVerticalField(options_.features, *camera_, input.T_W_B.q * T_B_C_.q);
    Features features = extractor_->Extract(input.image, vertical, pixels, &f.point_descriptors);
    f.keypoints.reserve(features.keypoints.size());
    for (const Keypoint& keypoint : features.keypoints) {
      f.keypoints.emplace_back(keypoint.x, keypoint.y);
    }
    f.descriptors = std::move(features.descriptors);
    f.descriptors.shrink_to_fit();
  }
  const StepTimer timer(&times->words);
  current.words = places_.Words(f.descriptors);
  return current;
}

void LoopCloserImpl::Append(const KeyframeInput& input, KeyframeReport* report) {
  const int sequence = keyframes_.sequence_count() - (report->is_new_sequence ? 0 : 1);
  StoredKeyframe keyframe;
  keyframe.stamp_ns = input.stamp_ns;
  keyframe.features.T_B_C = T_B_C_;
  report->index = keyframes_.Add(keyframe, sequence, input.T_W_B);
  report->sequence = sequence;
  starts_sequence_ = false;
}

void LoopCloserImpl::Triangulate(NewKeyframe* current, KeyframeTimes* times) {
  const StepTimer timer(&times->features);
  if (options_.motion_stereo.recent == 0) {
    return;
  }
  const int newest = keyframes_.newest();
  KeyframeFeatures& f = current->features;
  const auto images = stereo_.Add(newest,
                                  keyframes_.node(newest).T_W_B * f.T_B_C,
                                  MakeCornerView(f.keypoints, f.descriptors, *camera_),
                                  f.points_B.size(),
                                  MedianDepth(f));
  for (const MotionStereo::Image* image : images) {
    if (image->id == newest || keyframes_[image->id].is_place) {
      ReplaceOwnPoints(image->view,
                       *camera_,
                       options_.motion_stereo,
                       image->id == newest ? &f : &keyframes_.features(image->id));
    }
  }
}

void LoopCloserImpl::Refine(const std::vector<LoopMeasurement>& measurements) {
  for (const LoopMeasurement& measurement : measurements) {
    loops_.Refine(measurement, &keyframes_.graph());
  }
}

void LoopCloserImpl::TakeDueSolution(KeyframeReport* report) {
  const StepTimer timer(&report->times.graph);
  PoseGraph& graph = keyframes_.graph();
  report->graph_changed = solve_.TakeIfDue(&graph);
  if (report->graph_changed) {
    Withdraw(graph.WithdrawContradicted(options_.pose_graph.withdraw_after), &report->loops);
  }
  if (!solve_.is_pending() && (report->graph_changed || !solve_.has_news())) {
    const PoseGraph::Settled settled = graph.Reduce();
    loops_.Settle(settled.absorbed, graph);
    Withdraw(settled.withdrawn, &report->loops);
  }
}

void LoopCloserImpl::Withdraw(const std::vector<int>& edges, std::vector<LoopReport>* told) {
  TakeBack(loops_.Withdraw(edges, keyframes_.graph()), told);
}

void LoopCloserImpl::TakeBack(std::vector<LoopReport> withdrawn, std::vector<LoopReport>* told) {
  bool is_newest_gone = false;
  for (LoopReport& loop : withdrawn) {
    loop.stamp_old_ns = keyframes_[loop.old].stamp_ns;
    loop.stamp_current_ns = keyframes_[loop.current].stamp_ns;
    if (keyframes_[loop.current].relocalised_old == loop.old) {
      keyframes_.SetRelocalised(loop.current, -1);
    }
    is_newest_gone = is_newest_gone || loop.current == last_localised_;
    told->push_back(std::move(loop));
  }
  if (is_newest_gone) {
    last_localised_ = loops_.NewestLocalised();
  }
}

void LoopCloserImpl::TakeBackJoin(std::vector<LoopReport> withdrawn, KeyframeReport* report) {
  const std::size_t first = report->loops.size();
  TakeBack(std::move(withdrawn), &report->loops);
  for (std::size_t i = first; i < report->loops.size(); ++i) {
    const LoopReport& loop = report->loops[i];
    const auto is_of_loop = [&](const LoopMatches& matches) {
      return matches.stamp_current_ns == loop.stamp_current_ns &&
             matches.stamp_old_ns == loop.stamp_old_ns;
    };
    report->matches.erase(
        std::remove_if(report->matches.begin(), report->matches.end(), is_of_loop),
        report->matches.end());
    if (report->relocalisation && loop.current == report->index &&
        loop.old == report->relocalisation->old) {
      report->relocalisation.reset();
    }
  }
  solve_.Restart();
  report->separates = true;
  report->graph_changed = true;
}

void LoopCloserImpl::BecomePlace(NewKeyframe current, KeyframeTimes* times) {
  const StepTimer timer(&times->words);
  const int index = keyframes_.newest();
  if (question_ && question_->old < 0 && IsMeant(question_->stamp_old_ns)) {
    question_->old = index;
    question_->old_features = current.features;
  }
  if (options_.add_places &&
      policy_.IsNewPlace(CameraOf(index), current.features, CamerasAround(false))) {
    keyframes_.MakePlace(std::move(current.features));
    places_.Add(index, keyframes_.node(index).sequence, keyframes_[index].stamp_ns, current.words);
  }
  places_.Pass(std::move(current.words));
  shelf_.AttachWaiting(index, keyframes_);
}

void LoopCloserImpl::StartDueSolve(KeyframeTimes* times) {
  const StepTimer timer(&times->graph);
  solve_.StartIfDue(keyframes_.graph());
}

std::vector<LoopReport> LoopCloserImpl::OptimizeFully() {
  Refine(measurements_.TakeAll());
  solve_.Finish(&keyframes_.graph());
  keyframes_.graph().Solve();
  solve_.Reset();
  std::vector<LoopReport> withdrawn;
  Withdraw(keyframes_.graph().WithdrawContradicted(1), &withdrawn);
  return withdrawn;
}

bool LoopCloserImpl::UpdateLoop(int current, const Rigid3& T_Bold_Bcurrent) {
  if (current < 0 || current >= keyframes_.size()) {
    return false;
  }
  const LoopMeasurement measurement{keyframes_[current].relocalised_old, current, T_Bold_Bcurrent};
  measurements_.Add(measurement, keyframes_.newest());
  return loops_.CanRefine(measurement, keyframes_.graph());
}

Rigid3 LoopCloserImpl::drift() const {
  return starts_sequence_ ? Rigid3::Identity() : keyframes_.graph().Correction(keyframes_.newest());
}

std::size_t LoopCloserImpl::memory_bytes() const {
  constexpr std::size_t kPerKeyframe = 150;
  std::size_t bytes = places_.memory_bytes() + shelf_.memory_bytes() +
                      kPerKeyframe * static_cast<std::size_t>(keyframes_.size());
  for (int i = 0; i < keyframes_.size(); ++i) {
    bytes += keyframes_[i].is_place ? keyframes_.features(i).MemoryBytes() : 0;
  }
  return bytes;
}

std::size_t LoopCloserImpl::view_memory_bytes() const {
  return shelf_.memory_bytes() + places_.view_memory_bytes();
}

// Of loops that were absorbed nothing is left to tell that sequences are joined but the ties.
std::vector<LoopReport> LoopCloserImpl::LoopsAndJoints() const {
  std::vector<LoopReport> loops = loops_.Accepted();
  std::set<std::pair<int, int>> joined;
  for (const auto& [ends, tie] : keyframes_.graph().ties()) {
    const int a = keyframes_.node(tie.from).sequence;
    const int b = keyframes_.node(tie.to).sequence;
    if (a == b || !joined.insert({a, b}).second) {
      continue;
    }
    LoopReport loop;
    loop.old = tie.from;
    loop.current = tie.to;
    loop.stamp_old_ns = keyframes_[tie.from].stamp_ns;
    loop.stamp_current_ns = keyframes_[tie.to].stamp_ns;
    loop.T_Bold_Bcurrent = keyframes_.T_a_b(tie.from, tie.to);
    const Eigen::Matrix4d covariance = tie.information.ldlt().solve(Eigen::Matrix4d::Identity());
    loop.covariance.topLeftCorner<3, 3>() = covariance.topLeftCorner<3, 3>();
    loop.covariance.bottomRightCorner<3, 3>() = covariance(3, 3) * Eigen::Matrix3d::Identity();
    loops.push_back(loop);
  }
  return loops;
}

void LoopCloserImpl::Save(const std::filesystem::path& directory) const {
  WriteMap(directory,
           {DescriptorKind(options_.features), *camera_, places_},
           keyframes_,
           LoopsAndJoints(),
           shelf_.kept());
}

// Where the map has no words, to look them up is most of the work, and the same on any number of
// threads.
void LoopCloserImpl::AddLoadedPlaces(std::vector<PackedBow> words) {
  constexpr std::size_t kAtOnce = 8192;  // whose words wait for the index, some 5 kB each
  const KeyframeMap& keyframes = keyframes_;
  const std::vector<int>& places = keyframes.places();
  for (std::size_t first = 0; first < places.size(); first += kAtOnce) {
    std::vector<NewPlace> added(std::min(kAtOnce, places.size() - first));
    ParallelFor(0, added.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const int place = places[first + i];
        added[i] = {place,
                    keyframes.node(place).sequence,
                    keyframes[place].stamp_ns,
                    words.empty() ? places_.PackedWords(keyframes.features(place).descriptors)
                                  : std::move(words[first + i])};
      }
    });
    places_.AddAll(added);
  }
}

void LoopCloserImpl::Load(const std::filesystem::path& directory) {
  LoadedMap map = ReadMap(
      directory, {DescriptorKind(options_.features), *camera_, places_}, options_.pose_graph);
  solve_.Finish(&keyframes_.graph());
  solve_.Reset();
  measurements_.TakeAll();
  keyframes_ = std::move(map.keyframes);
  loops_ = LoopBook(options_.consistency, map.loops);
  places_.Clear();
  shelf_.Clear();
  AddLoadedPlaces(std::move(map.words));
  for (const int place : keyframes_.places()) {
    const auto views = map.views.find(place);
    if (views != map.views.end()) {
      shelf_.Restore(place, std::move(views->second));
    }
  }
  last_localised_ = -1;
  starts_sequence_ = true;
}

}  // namespace deja_view
