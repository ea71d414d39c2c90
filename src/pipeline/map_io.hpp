#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/pipeline/loop_closer_types.hpp"

#include <filesystem>
#include <string>
#include <vector>

#include "keyframe_map.hpp"
#include "place_finder.hpp"
#include "view_shelf.hpp"

namespace deja_view {

/// What a map's features were made with; a map fits no other. Only their words are looked up anew
/// where `finder` has another vocabulary or weighting.
struct MapMaker {
  std::string descriptor_name;
  const Camera& camera;
  const PlaceFinder& finder;
};

/// A map as read from its file.
struct LoadedMap {
  KeyframeMap keyframes;
  std::vector<LoopReport> loops;
  ViewShelf::Views views;
  /// Of the places, in their order; empty where the file has none that the finder would look up.
  std::vector<PackedBow> words;
};

/// Writes a map to `directory`/map.dvm, whole or not at all. `loops` tell which sequences are
/// joined. Throws InputError when it can't be written.
void WriteMap(const std::filesystem::path& directory,
              const MapMaker& maker,
              const KeyframeMap& keyframes,
              const std::vector<LoopReport>& loops,
              const ViewShelf::Views& views);

/// Throws InputError, naming file and field, for a file that is no map, damaged, or of another
/// maker.
LoadedMap ReadMap(const std::filesystem::path& directory,
                  const MapMaker& maker,
                  const PoseGraphOptions& options);

}  // namespace deja_view
