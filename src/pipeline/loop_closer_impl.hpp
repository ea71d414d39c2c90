#pragma once

#include "deja_view/features/feature_extractor.hpp"
#include "deja_view/pipeline/loop_closer_options.hpp"
#include "deja_view/pipeline/loop_closer_types.hpp"
#include "deja_view/triangulation/motion_stereo.hpp"
#include "deja_view/verification/loop_verifier.hpp"

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "keyframe_map.hpp"
#include "loop_book.hpp"
#include "loop_measurements.hpp"
#include "place_finder.hpp"
#include "place_policy.hpp"
#include "solve_schedule.hpp"
#include "track_depths.hpp"
#include "view_shelf.hpp"

namespace deja_view {

/// The parts of LoopCloser, and the steps of a keyframe through them.
class LoopCloserImpl {
 public:
  LoopCloserImpl(const LoopCloserOptions& options,
                 std::shared_ptr<const Camera> camera,
                 const Rigid3& T_B_C,
                 std::shared_ptr<const Vocabulary> vocabulary,
                 SolveExecutor executor);
  LoopCloserImpl(const LoopCloserImpl&) = delete;
  LoopCloserImpl& operator=(const LoopCloserImpl&) = delete;

  KeyframeReport AddKeyframe(const KeyframeInput& input);
  ViewOutcome AddVirtualView(const VirtualView& view) { return shelf_.Add(view, keyframes_); }
  void SetExtrinsic(const Rigid3& T_B_C) { T_B_C_ = T_B_C; }
  void Ask(std::int64_t stamp_current_ns, std::int64_t stamp_old_ns, std::int64_t within_ns);
  bool UpdateLoop(int current, const Rigid3& T_Bold_Bcurrent);
  std::vector<LoopReport> OptimizeFully();
  void Save(const std::filesystem::path& directory) const;
  void Load(const std::filesystem::path& directory);

  const KeyframeMap& keyframes() const { return keyframes_; }
  const LoopBook& loops() const { return loops_; }
  const ViewShelf& shelf() const { return shelf_; }
  /// Identity until the first keyframe of a session.
  Rigid3 drift() const;
  std::size_t memory_bytes() const;
  std::size_t view_memory_bytes() const;

 private:
  /// The keyframe under way. Only a place keeps its features.
  struct NewKeyframe {
    KeyframeFeatures features;
    ImageWords words;
  };

  // The steps of AddKeyframe, in their order.
  void CheckInput(const KeyframeInput& input) const;
  bool StartsSequence(const KeyframeInput& input) const;
  NewKeyframe Describe(const KeyframeInput& input, bool is_new_sequence, KeyframeTimes* times);
  void Append(const KeyframeInput& input, KeyframeReport* report);
  /// Makes points of corners, of the new keyframe and of the places lately passed.
  void Triangulate(NewKeyframe* current, KeyframeTimes* times);
  void Refine(const std::vector<LoopMeasurement>& measurements);
  void TakeDueSolution(KeyframeReport* report);
  /// Loops that are none in the graph any more.
  void Withdraw(const std::vector<int>& edges, std::vector<LoopReport>* told);
  void TakeBack(std::vector<LoopReport> withdrawn, std::vector<LoopReport>* told);
  /// The sequence under way was joined wrongly, by these loops.
  void TakeBackJoin(std::vector<LoopReport> withdrawn, KeyframeReport* report);
  std::vector<Candidate> FindCandidates(const NewKeyframe& current, KeyframeReport* report) const;
  void FindLoops(const std::vector<Candidate>& candidates,
                 const NewKeyframe& current,
                 KeyframeReport* report);
  void BecomePlace(NewKeyframe current, KeyframeTimes* times);
  void StartDueSolve(KeyframeTimes* times);

  /// Whether the newest keyframe is the one of the stamp.
  bool IsMeant(std::int64_t stamp_ns) const;
  /// Answers what was asked of this pair of keyframes, and forgets the question.
  void Explain(const std::vector<Candidate>& candidates,
               const NewKeyframe& current,
               KeyframeReport* report);
  PairExplanation::Attempt Attempt(int old,
                                   const KeyframeFeatures& old_features,
                                   bool with_views,
                                   const NewKeyframe& current) const;

  /// Makes a loaded map's places known by their words.
  void AddLoadedPlaces(std::vector<PackedBow> words);

  NearbyPlace CameraOf(int keyframe) const;
  /// The cameras of all places in the newest keyframe's world.
  std::vector<NearbyPlace> CamerasAround(bool with_views) const;
  /// A loop was accepted so lately that the corrected pose is the better guess.
  bool IsLocalised() const;
  bool IsWithinReach(int old, const NewKeyframe& current) const;
  std::vector<std::vector<RigCamera>> RigsOf(int old,
                                             const KeyframeFeatures& old_features,
                                             const NewKeyframe& current) const;
  Verification VerifyPair(int old,
                          const KeyframeFeatures& old_features,
                          bool with_views,
                          const NewKeyframe& current) const;
  LoopReport Verify(const Candidate& candidate,
                    bool with_views,
                    const NewKeyframe& current,
                    Verification* verification) const;
  /// A loop that passed its gates: true when it is consistent with the others and in the graph now.
  bool TakeVerified(const LoopReport& loop,
                    const Verification& verification,
                    const NewKeyframe& current,
                    KeyframeReport* report);
  /// What a believed loop says was known before, so that others would say it again.
  bool IsKnownWell(int record) const;
  Relocalisation MakeRelocalisation(const LoopReport& loop,
                                    const Verification& verification,
                                    const NewKeyframe& current) const;
  std::vector<LoopReport> LoopsAndJoints() const;
  static std::vector<LoopMatches::Pair> PairsOf(const Verification& verification);

  /// A pair of keyframes to be explained.
  struct Question {
    std::int64_t stamp_current_ns = 0;
    std::int64_t stamp_old_ns = 0;
    std::int64_t within_ns = 0;
    int old = -1;                   ///< once it is there
    KeyframeFeatures old_features;  ///< of a keyframe of this flight, place or not
  };

  LoopCloserOptions options_;
  std::shared_ptr<const Camera> camera_;
  Rigid3 T_B_C_;
  std::unique_ptr<FeatureExtractor> extractor_;
  LoopVerifier verifier_;
  TrackDepths tracks_;
  MotionStereo stereo_;
  PlacePolicy policy_;
  PlaceFinder places_;
  ViewShelf shelf_;
  KeyframeMap keyframes_;
  LoopBook loops_;
  SolveSchedule solve_;
  LoopMeasurements measurements_;
  std::optional<Question> question_;
  bool starts_sequence_ = true;  ///< the next keyframe does
  int last_localised_ = -1;      ///< newest keyframe with an accepted loop
};

}  // namespace deja_view
