#pragma once

#include "deja_view/pose_graph/pose_graph.hpp"
#include "deja_view/verification/loop_verifier.hpp"

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

namespace deja_view {

/// A keyframe on its way to a map, from a file or from the odometry.
struct StoredKeyframe {
  std::int64_t stamp_ns = 0;
  bool is_place = false;      ///< can be recognised
  KeyframeFeatures features;  ///< all of a place's, else T_B_C alone
};

/// All keyframes with their poses: keyframe i is node i of the pose graph. A keyframe that is no
/// place takes 150 bytes here and there, whatever it saw.
class KeyframeMap {
 public:
  explicit KeyframeMap(const PoseGraphOptions& options) : graph_(options) {}
  /// Throws CheckError when the two are of different sizes.
  KeyframeMap(std::vector<StoredKeyframe> keyframes, PoseGraph graph);

  /// Appends a keyframe; returns its index.
  int Add(const StoredKeyframe& keyframe, int sequence, const Rigid3& T_W_B);
  /// Makes the newest keyframe a place to recognise.
  void MakePlace(KeyframeFeatures features);
  /// Of a place.
  KeyframeFeatures& features(int i);
  const KeyframeFeatures& features(int i) const;
  const Rigid3& T_B_C(int i) const {
    return extrinsics_[static_cast<std::size_t>((*this)[i].extrinsic)];
  }
  void SetRelocalised(int i, int old) {
    keyframes_.at(static_cast<std::size_t>(i)).relocalised_old = old;
  }

  int size() const { return graph_.size(); }
  int newest() const { return size() - 1; }
  struct Keyframe {
    std::int64_t stamp_ns = 0;
    bool is_place = false;     ///< can be recognised
    int relocalised_old = -1;  ///< of the relocalisation that the VIO was told of
    int extrinsic = 0;         ///< index of extrinsics_
    int place = -1;            ///< index of features_
  };
  const Keyframe& operator[](int i) const { return keyframes_.at(static_cast<std::size_t>(i)); }
  PoseGraphNode node(int i) const { return graph_.node(i); }
  const PoseGraph& graph() const { return graph_; }
  PoseGraph& graph() { return graph_; }

  /// The keyframes that are places, the oldest first.
  const std::vector<int>& places() const { return places_; }
  /// Sequences so far.
  int sequence_count() const { return size() == 0 ? 0 : node(newest()).sequence + 1; }
  /// True when their poses are of one world.
  bool AreJoined(int a, int b) const {
    return graph_.AreJoined(node(a).sequence, node(b).sequence);
  }
  /// Corrected pose of the camera.
  Rigid3 T_M_C(int i) const { return node(i).T_M_B() * T_B_C(i); }
  /// Corrected pose of `b`'s body in that of `a`; both of one world.
  Rigid3 T_a_b(int a, int b) const { return node(a).T_M_B().Inverse() * node(b).T_M_B(); }

  /// The keyframe of a stamp to within 500 ns, as VIOs round stamps to doubles of seconds (120 ns);
  /// the newest of several.
  std::optional<int> At(std::int64_t stamp_ns) const;
  static bool IsSameStamp(std::int64_t a_ns, std::int64_t b_ns);

 private:
  void Append(const StoredKeyframe& keyframe);
  void AddFeatures(int i, KeyframeFeatures features);

  // No vectors, which would have to move it all at times.
  std::deque<Keyframe> keyframes_;
  std::deque<KeyframeFeatures> features_;  ///< of the places
  std::deque<Rigid3> extrinsics_;          ///< T_B_C that were in use, one after the other
  PoseGraph graph_;
  std::vector<int> places_;
  std::vector<int> first_;  ///< keyframe of each sequence: within one, stamps count up
};

}  // namespace deja_view
