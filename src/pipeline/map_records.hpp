#pragma once

#include "deja_view/base/binary_stream.hpp"
#include "deja_view/pose_graph/pose_graph.hpp"

#include "keyframe_map.hpp"
#include "loop_book.hpp"
#include "place_finder.hpp"
#include "stored_view.hpp"

namespace deja_view {

// What a map file holds, one record after the other. The readers throw InputError that names the
// field for what can't be.

void WriteKeyframe(const KeyframeMap& keyframes, int keyframe, BinaryWriter* out);
/// A keyframe of `camera`, and its node, which is a fixed one.
void ReadKeyframe(BinaryReader* in,
                  const Camera& camera,
                  StoredKeyframe* keyframe,
                  PoseGraphNode* node);

void WriteLoop(const LoopReport& loop, BinaryWriter* out);
/// A loop between two of `keyframes`.
PoseGraphLoop ReadLoop(BinaryReader* in,
                       const std::vector<StoredKeyframe>& keyframes,
                       LoopReport* report);

void WriteView(int keyframe, const StoredView& view, BinaryWriter* out);
/// A view of one of `keyframe_count` keyframes.
StoredView ReadView(BinaryReader* in, std::size_t keyframe_count, int* keyframe);

void WriteWords(const PackedBow& words, BinaryWriter* out);
/// Words that `finder` might have looked up for an image with so many descriptors.
PackedBow ReadWords(BinaryReader* in, std::size_t descriptor_count, const PlaceFinder& finder);

}  // namespace deja_view
