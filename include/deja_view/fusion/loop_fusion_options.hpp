#pragma once

#include "deja_view/front_end/odometry_front_end.hpp"
#include "deja_view/host/keyframe_assembler.hpp"
#include "deja_view/pipeline/loop_closer_options.hpp"

#include <string>
#include <vector>

namespace deja_view {

/// How the node runs; all of it is without influence on the loops as long as nothing overflows.
struct NodeOptions {
  int queue_size = 100;  ///< keyframes that wait for the loop closer; more: the oldest is dropped
  int virtual_queue_size = 400;  ///< of these, virtual views; more: the oldest view is dropped
  double queue_memory_mb = 500;  ///< [MB] of the images of keyframes, and of views, that wait;
                                 ///< more: the oldest is dropped
  double drain_s = 8.0;  ///< [s] for the keyframes that still wait when the node is told to stop
  double path_rate_hz = 5.0;  ///< [Hz] of paths and the pose graph's markers, when they changed
  int path_poses = 10000;     ///< of all paths together at most; a longer flight's are thinned
  double diagnostics_rate_hz = 1.0;  ///< [Hz]
  bool match_image = true;  ///< keep small pictures of the keyframes, to show loops (10 kB each)
  int match_image_memory = 2000;  ///< newest keyframes whose picture is kept

  /// All violations, each with its key; empty when all is well.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("queue_size", queue_size);
    v("virtual_queue_size", virtual_queue_size);
    v("queue_memory_mb", queue_memory_mb);
    v("drain_s", drain_s);
    v("path_rate_hz", path_rate_hz);
    v("path_poses", path_poses);
    v("diagnostics_rate_hz", diagnostics_rate_hz);
    v("match_image", match_image);
    v("match_image_memory", match_image_memory);
  }
};

/// The whole config file, of the node and of a replay alike: the loop closer's keys at the top
/// level, and the groups `assembler`, `front_end` (of hosts that give poses alone) and `node`.
struct LoopFusionOptions {
  LoopCloserOptions loop_closer;
  KeyframeAssemblerOptions assembler;
  OdometryFrontEndOptions front_end;
  NodeOptions node;

  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    loop_closer.Visit(v);
    v("assembler", assembler);
    v("front_end", front_end);
    v("node", node);
  }
};

}  // namespace deja_view
