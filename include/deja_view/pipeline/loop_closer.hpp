#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/pipeline/loop_closer_options.hpp"
#include "deja_view/pipeline/loop_closer_types.hpp"
#include "deja_view/views/virtual_view.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

namespace deja_view {

class LoopCloserImpl;

/// Loop closing over a stream of keyframes: features, words, candidates, verification, pose graph.
///
/// Synchronous, deterministic and without threads of its own: the same keyframes in the same order
/// give the same bits. Not thread-safe; the node guards it with one mutex. A long graph solve can
/// be moved out of the keyframe's way: see SolveExecutor.
class LoopCloser {
 public:
  /// `executor` may be empty: graphs are then solved in the caller's thread. Throws InputError for
  /// options that are not valid or a vocabulary made for another descriptor than the options ask
  /// for.
  LoopCloser(const LoopCloserOptions& options,
             std::shared_ptr<const Camera> camera,
             const Rigid3& T_B_C,
             std::shared_ptr<const Vocabulary> vocabulary,
             SolveExecutor executor = {});
  ~LoopCloser();
  LoopCloser(LoopCloser&&) noexcept;
  LoopCloser& operator=(LoopCloser&&) noexcept;

  /// Camera extrinsics from the VIO's online calibration; used from the next keyframe on.
  void SetExtrinsic(const Rigid3& T_B_C);

  /// Adds a keyframe, looks for loops and feeds the graph. Throws InputError, and leaves everything
  /// as it was, for a keyframe that can't be used: image of another size or type, pose not finite.
  /// Points that are not finite are left out. A new sequence starts with `starts_sequence`, with a
  /// stamp that goes back, and with a jump of the pose that no drone can fly.
  KeyframeReport AddKeyframe(const KeyframeInput& input);

  /// Adds a view to the keyframe of its stamp (to within 500 ns, as VIOs round stamps), be it in
  /// the map already or still to come; the newest of several keyframes of one stamp. Throws
  /// InputError, and counts it, for a view that can't be used: neither an image nor features for
  /// the vocabulary, sizes that do not agree, values that are not finite.
  ViewOutcome AddVirtualView(const VirtualView& view);

  /// From now on the keyframe of the one stamp is explained against that of the other, which comes
  /// before it or is a place of the loaded map: KeyframeReport::explanation. The first keyframes
  /// whose stamps differ by at most `within_ns` are meant. Changes nothing else.
  void Ask(std::int64_t stamp_current_ns, std::int64_t stamp_old_ns, std::int64_t within_ns);

  /// The VIO's own measurement after fast relocalisation: pose of keyframe `current` relative to
  /// the old keyframe of its Relocalisation, refined over the VIO's window. Ignored, with false,
  /// when that keyframe had none or the pose is far from the loop's. Used with a later keyframe
  /// (SolveOptions::measurement_latency), so that it does not matter between which ones it came.
  bool UpdateLoop(int current, const Rigid3& T_Bold_Bcurrent);

  /// Solves the graph to convergence over everything added so far; call at the end of a flight.
  /// Returns the loops that it contradicts and that were withdrawn, as KeyframeReport::loops tells
  /// of them.
  std::vector<LoopReport> OptimizeFully();

  int keyframe_count() const;
  KeyframeInfo keyframe(int index) const;
  int sequence_count() const;
  /// True when loops tie the sequence to the map's first one: its corrected poses are in frame M.
  bool is_joined(int sequence) const;
  /// Keyframes that can be recognised (all, or those that map_spacing_m left).
  int place_count() const;
  /// Heap memory [bytes] of keyframes and index.
  std::size_t memory_bytes() const;

  const ViewCounts& view_counts() const;
  /// Heap memory [bytes] of the virtual views kept, with their part of the index; in memory_bytes.
  std::size_t view_memory_bytes() const;

  /// T_M_W of the current sequence: corrects the newest VIO poses. Four degrees of freedom.
  Rigid3 drift() const;

  /// Accepted loops in the graph now, of a loaded map first. Those that have become part of what
  /// places know of each other (PoseGraph) are none any more.
  std::vector<LoopReport> accepted_loops() const;

  /// Writes the whole map (keyframes, features, graph) to `directory`/map.dvm: versioned,
  /// checksummed, renamed into place when complete. Words are not in it; they are looked up again
  /// at loading, so that a map can be opened with another vocabulary for the same descriptor.
  /// Throws InputError when it can't be written.
  void Save(const std::filesystem::path& directory) const;

  /// Replaces the content with a saved map; its sequences stay fixed parts of the map that a new
  /// sequence can be joined to. On a bad map throws InputError, naming file and field, and keeps
  /// what it had.
  void Load(const std::filesystem::path& directory);

 private:
  std::unique_ptr<LoopCloserImpl> impl_;
};

}  // namespace deja_view
