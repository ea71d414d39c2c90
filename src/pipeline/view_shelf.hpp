#pragma once

#include "deja_view/features/feature_extractor.hpp"
#include "deja_view/pipeline/loop_closer_options.hpp"
#include "deja_view/pipeline/loop_closer_types.hpp"
#include "deja_view/verification/loop_verifier.hpp"
#include "deja_view/views/virtual_view.hpp"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "camera_table.hpp"
#include "keyframe_map.hpp"
#include "place_finder.hpp"
#include "stored_view.hpp"

namespace deja_view {

/// A camera near a keyframe's own.
struct NearCamera {
  Rigid3 T_C_near;   ///< [m]
  double depth = 0;  ///< of the scene [m]; 0: unknown
};

/// The virtual views of places, from their arrival to the index: those that wait for their
/// keyframe, and the best of each keyframe that came.
class ViewShelf {
 public:
  /// Keyframe and its views, in the order of keeping.
  using Views = std::map<int, std::vector<StoredView>>;

  /// `verifier` and `places` outlive the shelf; the views kept are always those that `places` has.
  ViewShelf(const VirtualViewOptions& options,
            const FeatureOptions& features,
            const LoopVerifier* verifier,
            PlaceFinder* places);

  /// Puts a view to its keyframe, or lets it wait for it. Throws InputError, and counts it, for a
  /// view that can't be used.
  ViewOutcome Add(const VirtualView& view, const KeyframeMap& keyframes);

  /// Puts the views that waited for `keyframe` to it.
  void AttachWaiting(int keyframe, const KeyframeMap& keyframes);

  /// Begins anew with a loaded map's views: first Clear, then Restore for each place in order.
  /// Waiting views stay.
  void Clear();
  void Restore(int keyframe, std::vector<StoredView> views);

  const std::vector<StoredView>& Of(int keyframe) const;
  const Views& kept() const { return kept_; }
  /// The keyframe's views as cameras of rigs around its own, the best first: `in_rig` in each,
  /// those nearest to `near` in the first, the next ones in the second, until there are `rigs`.
  /// Where `near` is not known, those whose words are most like `bow`, the drone's image's, come
  /// first. What is far off sees little of the same, and its chance matches hide the others'.
  std::vector<std::vector<RigCamera>> RigsOf(int keyframe,
                                             const Rigid3& T_B_C,
                                             const std::optional<NearCamera>& near,
                                             const BowVector& bow) const;

  const ViewCounts& counts() const { return counts_; }
  /// Heap memory [bytes] of the views kept, without their part of the index.
  std::size_t memory_bytes() const { return bytes_; }

 private:
  ViewOutcome TryToAdd(const VirtualView& view, const KeyframeMap& keyframes);
  ViewOutcome Attach(int keyframe, const VirtualView& sent, const KeyframeMap& keyframes);
  void LetWait(const VirtualView& view);
  StoredView Describe(const VirtualView& view, const Rigid3& T_W_C) const;
  ViewOutcome Count(ViewOutcome outcome);
  void Keep(int keyframe, StoredView view);
  void Drop(int keyframe, std::size_t i);
  bool AgreesWithSource(const KeyframeFeatures& source, const StoredView& view) const;
  std::vector<std::size_t> Order(const std::vector<StoredView>& views,
                                 const std::optional<NearCamera>& near,
                                 const BowVector& bow) const;
  double SimilarityToSource(const KeyframeFeatures& source, const StoredView& view) const;
  std::optional<std::size_t> FindSurpassed(const KeyframeFeatures& source,
                                           std::vector<StoredView>* views,
                                           StoredView* view) const;

  VirtualViewOptions options_;
  FeatureOptions features_;
  std::unique_ptr<FeatureExtractor> extractor_;
  const LoopVerifier* verifier_;
  PlaceFinder* places_;
  CameraTable cameras_;
  std::deque<VirtualView> waiting_;  ///< the oldest first
  std::size_t waiting_bytes_ = 0;
  Views kept_;
  ViewCounts counts_;
  std::size_t bytes_ = 0;
};

}  // namespace deja_view
