#pragma once

#include "deja_view/pipeline/loop_closer.hpp"
#include "deja_view/pose_graph/loop_consistency.hpp"
#include "deja_view/pose_graph/pose_graph.hpp"
#include "deja_view/verification/loop_verifier.hpp"

#include <deque>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "camera_table.hpp"
#include "candidates.hpp"
#include "stored_view.hpp"

namespace deja_view {

/// A keyframe as it is kept.
struct StoredKeyframe {
  std::int64_t stamp_ns = 0;
  int sequence = 0;
  bool is_place = false;     ///< in the place database, with features
  int relocalised_old = -1;  ///< of the relocalisation that the VIO was told of
  KeyframeFeatures features;
  BowVector bow;
  std::vector<StoredView> views;
};

/// State and steps of LoopCloser.
class LoopCloser::Impl {
 public:
  Impl(const LoopCloserOptions& options,
       std::shared_ptr<const Camera> camera,
       const Rigid3& T_B_C,
       std::shared_ptr<const Vocabulary> vocabulary,
       SolveExecutor executor);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  KeyframeReport AddKeyframe(const KeyframeInput& input);
  ViewOutcome AddVirtualView(const VirtualView& view);
  bool UpdateLoop(int current, const Rigid3& T_Bold_Bcurrent);
  void OptimizeFully();
  /// Identity until the first keyframe of a session.
  Rigid3 drift() const {
    return starts_sequence_ ? Rigid3::Identity() : graph.Correction(graph.size() - 1);
  }
  void Save(const std::filesystem::path& directory) const;
  void Load(const std::filesystem::path& directory);

  LoopCloserOptions options;
  std::shared_ptr<const Camera> camera;
  Rigid3 T_B_C;
  std::shared_ptr<const Vocabulary> vocabulary;
  SolveExecutor executor;
  std::unique_ptr<FeatureExtractor> extractor;
  LoopVerifier verifier;

  std::vector<StoredKeyframe> keyframes;
  PoseGraph graph;
  PlaceDatabase places;
  LoopConsistency consistency;
  std::vector<LoopReport> reports;   ///< every loop that passed verification, by consistency's tag
  std::vector<LoopReport> accepted;  ///< one per loop of the graph, in its order
  int sequence = -1;                 ///< of the newest keyframe
  ViewCounts view_counts;

  std::size_t ViewMemoryBytes() const;

 private:
  /// A snapshot of the graph under way.
  struct PendingSolve {
    std::shared_ptr<PoseGraph> snapshot;
    std::future<void> done;  ///< invalid when solved already
    int due = 0;             ///< index of the keyframe that takes the solution over
  };

  /// A map as read from its file, before it replaces the present one.
  struct LoadedMap {
    std::vector<StoredKeyframe> keyframes;
    PoseGraph graph{PoseGraphOptions{}};
    std::vector<LoopReport> accepted;
  };

  struct WaitingView {
    std::int64_t stamp_ns = 0;
    StoredView view;
  };

  LoadedMap ReadMap(const std::filesystem::path& directory) const;
  void IndexMap();
  void CheckInput(const KeyframeInput& input) const;
  bool StartsSequence(const KeyframeInput& input) const;
  void ExtractFeatures(const KeyframeInput& input, StoredKeyframe* keyframe);
  double DepthSigma(const TrackedPoint& point, const Eigen::Vector3d& centre_W);
  /// The point in the body frame: its distance from the VIO's landmark, its direction from where it
  /// was tracked in this very image. Nothing for a point that does not fit its pixel.
  std::optional<Eigen::Vector3d> LocatePoint(const TrackedPoint& point, const Rigid3& T_C_W) const;
  int NewestOldEnough() const;
  NearbyPlace PlaceOf(int keyframe) const;
  void AddViewPlaces(int keyframe, std::vector<NearbyPlace>* around) const;
  bool IsLocalised() const;
  std::vector<Candidate> FindCandidates(KeyframeReport* report) const;
  LoopReport VerifyCandidate(const Candidate& candidate,
                             bool with_views,
                             Verification* verification) const;
  /// A loop that passed its gates: true when it is consistent with the others and in the graph now.
  bool TakeVerified(LoopReport loop, const Verification& verification, KeyframeReport* report);
  bool IsWithinReach(int old) const;
  void FindLoops(KeyframeReport* report);
  void Believe(const std::vector<LoopConsistency::Entry>& entries, KeyframeReport* report);
  Relocalisation MakeRelocalisation(const LoopReport& loop, const Verification& verification) const;
  LoopMatches MakeMatches(const LoopReport& loop, const Verification& verification) const;
  bool IsNewPlace() const;
  std::optional<std::size_t> KeyframeAt(std::int64_t stamp_ns) const;
  ViewOutcome Count(ViewOutcome outcome);
  void AttachWaitingViews(std::size_t keyframe);
  ViewOutcome AttachView(std::size_t keyframe, StoredView view);
  void IndexView(std::size_t keyframe, StoredView view);
  bool AgreesWithSource(const StoredKeyframe& keyframe, const StoredView& view) const;
  double SimilarityToSource(const StoredKeyframe& keyframe, const StoredView& view) const;
  std::optional<std::size_t> FindSurpassed(StoredKeyframe* keyframe, StoredView* view) const;
  std::vector<RigCamera> RigOf(std::size_t keyframe) const;
  void AddPlace(int keyframe, const BowVector& bow, int tag);
  std::vector<RetrievedPlace> Retrieve(int newest, KeyframeReport* report) const;
  std::vector<RetrievedPlace> RetrieveFast(int newest) const;
  /// Retrieves and judges islands by the paper's scores.
  std::vector<RetrievedPlace> RetrieveScored(int newest, KeyframeReport* report) const;
  /// The current keyframe's score against its predecessors.
  double OwnScore(const WeightedBow& words) const;
  void RememberWords();
  void ScheduleSolve();
  void TakeDueSolution(bool wait_for_all, KeyframeReport* report);

  /// Where a track was first seen from [m, in W], and the keyframe that saw it last.
  struct Track {
    Eigen::Vector3d first_centre_W;
    std::size_t last_keyframe = 0;
  };

  std::unordered_map<std::int64_t, Track> tracks_;
  std::unique_ptr<FeatureExtractor> view_extractor_;
  std::optional<ScoredPlaces> scored_places_;  ///< with scoring.is_on
  WeightedBow weighted_words_;                 ///< of the current keyframe
  std::deque<WeightedBow> predecessors_;       ///< words of the newest keyframes, for OwnScore
  CameraTable cameras_;
  std::deque<WaitingView> waiting_views_;       ///< the oldest first
  std::map<std::int64_t, std::size_t> stamps_;  ///< newest keyframe of each stamp
  std::size_t view_bytes_ = 0;
  std::size_t view_words_ = 0;  ///< in the index
  std::size_t place_words_ = 0;
  std::size_t empty_index_bytes_ = 0;
  std::optional<PendingSolve> pending_solve_;
  bool starts_sequence_ = true;  ///< the next keyframe does
  int loops_since_solve_ = 0;
  bool is_surprised_ = false;
  int last_localised_ = -1;  ///< newest keyframe with an accepted loop
};

}  // namespace deja_view
