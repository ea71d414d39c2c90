#include "map_io.hpp"

#include "deja_view/base/binary_stream.hpp"
#include "deja_view/base/parallel.hpp"

#include <algorithm>
#include <utility>

#include "map_records.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

// Version 3: the head is base's, and the number of views always there. Version 4: the places'
// words.
constexpr std::uint32_t kWithWords = 4;
constexpr BinaryFormat kFormat{
    {'D', 'J', 'A', 'E', 'V', 'M', 'A', 'P'}, kWithWords, "a saved map", 3};
constexpr const char* kFileName = "map.dvm";

void CheckMaker(BinaryReader* in, const MapMaker& maker) {
  const auto name = in->ReadAll<char>("descriptor name");
  if (std::string(name.begin(), name.end()) != maker.descriptor_name) {
    in->Fail("descriptor name",
             fmt::format("the map was made with '{}', the options (features.kind and orientation) "
                         "ask for '{}'",
                         std::string(name.begin(), name.end()),
                         maker.descriptor_name));
  }
  if (in->Read<std::int32_t>("image width") != maker.camera.width() ||
      in->Read<std::int32_t>("image height") != maker.camera.height()) {
    in->Fail("image size", "the map was made with another camera");
  }
}

void ReadKeyframes(BinaryReader* in,
                   const Camera& camera,
                   std::vector<StoredKeyframe>* keyframes,
                   std::vector<PoseGraphNode>* nodes) {
  const auto count = in->Read<std::uint64_t>("number of keyframes");
  for (std::uint64_t i = 0; i < count; ++i) {
    StoredKeyframe keyframe;
    PoseGraphNode node;
    ReadKeyframe(in, camera, &keyframe, &node);
    const int expected = nodes->empty() ? 0 : nodes->back().sequence;
    if (node.sequence != expected && node.sequence != expected + 1) {
      in->Fail("keyframe sequence", "not numbered in order");
    }
    keyframes->push_back(std::move(keyframe));
    nodes->push_back(node);
  }
}

std::vector<PoseGraphLoop> ReadLoops(BinaryReader* in,
                                     const std::vector<StoredKeyframe>& keyframes,
                                     std::vector<LoopReport>* reports) {
  const auto count = in->Read<std::uint64_t>("number of loops");
  std::vector<PoseGraphLoop> loops;
  for (std::uint64_t i = 0; i < count; ++i) {
    LoopReport report;
    loops.push_back(ReadLoop(in, keyframes, &report));
    reports->push_back(report);
  }
  return loops;
}

ViewShelf::Views ReadViews(BinaryReader* in, std::size_t keyframe_count) {
  const auto count = in->Read<std::uint64_t>("number of views");
  ViewShelf::Views all;
  for (std::uint64_t i = 0; i < count; ++i) {
    int keyframe = 0;
    StoredView view = ReadView(in, keyframe_count, &keyframe);
    std::vector<StoredView>& views = all[keyframe];
    const auto has_index = [&](const StoredView& other) { return other.index == view.index; };
    if (std::any_of(views.begin(), views.end(), has_index)) {
      in->Fail("view index", "two views of one keyframe have it");
    }
    views.push_back(std::move(view));
  }
  return all;
}

void WriteAllWords(const KeyframeMap& keyframes, const PlaceFinder& finder, BinaryWriter* out) {
  constexpr std::size_t kAtOnce = 4096;  // whose words wait to be written, some 5 kB each
  const std::vector<int>& places = keyframes.places();
  out->Write(finder.words_identity());
  for (std::size_t first = 0; first < places.size(); first += kAtOnce) {
    std::vector<PackedBow> words(std::min(kAtOnce, places.size() - first));
    ParallelFor(0, words.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        words[i] = finder.PackedWords(keyframes.features(places[first + i]).descriptors);
      }
    });
    for (const PackedBow& its : words) {
      WriteWords(its, out);
    }
  }
}

std::vector<PackedBow> ReadAllWords(BinaryReader* in,
                                    const std::vector<StoredKeyframe>& keyframes,
                                    const PlaceFinder& finder) {
  if (in->version() < kWithWords) {
    return {};
  }
  if (in->Read<std::uint64_t>("words' maker") != finder.words_identity()) {
    in->Skip(in->left(), "words");
    return {};
  }
  std::vector<PackedBow> words;
  for (const StoredKeyframe& keyframe : keyframes) {
    if (keyframe.is_place) {
      words.push_back(ReadWords(in, keyframe.features.descriptors.size(), finder));
    }
  }
  return words;
}

std::uint64_t CountViews(const ViewShelf::Views& views) {
  std::uint64_t count = 0;
  for (const auto& [keyframe, its] : views) {
    count += its.size();
  }
  return count;
}

}  // namespace

void WriteMap(const fs::path& directory,
              const MapMaker& maker,
              const KeyframeMap& keyframes,
              const std::vector<LoopReport>& loops,
              const ViewShelf::Views& views) {
  WriteBinaryFile(directory / kFileName, kFormat, [&](BinaryWriter* out) {
    out->WriteAll(maker.descriptor_name);
    out->Write(static_cast<std::int32_t>(maker.camera.width()));
    out->Write(static_cast<std::int32_t>(maker.camera.height()));
    out->Write(static_cast<std::uint64_t>(keyframes.size()));
    for (int i = 0; i < keyframes.size(); ++i) {
      WriteKeyframe(keyframes, i, out);
    }
    out->Write(static_cast<std::uint64_t>(loops.size()));
    for (const LoopReport& loop : loops) {
      WriteLoop(loop, out);
    }
    out->Write(CountViews(views));
    for (const auto& [keyframe, its] : views) {
      for (const StoredView& view : its) {
        WriteView(keyframe, view, out);
      }
    }
    WriteAllWords(keyframes, maker.finder, out);
  });
}

LoadedMap ReadMap(const fs::path& directory,
                  const MapMaker& maker,
                  const PoseGraphOptions& options) {
  BinaryReader in(directory / kFileName, kFormat);
  CheckMaker(&in, maker);
  std::vector<StoredKeyframe> keyframes;
  std::vector<PoseGraphNode> nodes;
  ReadKeyframes(&in, maker.camera, &keyframes, &nodes);
  std::vector<LoopReport> reports;
  const std::vector<PoseGraphLoop> loops = ReadLoops(&in, keyframes, &reports);
  ViewShelf::Views views = ReadViews(&in, keyframes.size());
  std::vector<PackedBow> words = ReadAllWords(&in, keyframes, maker.finder);
  in.Finish();
  std::vector<PoseGraph::Part> parts;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    parts.push_back({nodes[i], keyframes[i].is_place});
  }
  PoseGraph graph = PoseGraph::FromParts(options, parts, loops);
  return {KeyframeMap(std::move(keyframes), std::move(graph)),
          std::move(reports),
          std::move(views),
          std::move(words)};
}

}  // namespace deja_view
