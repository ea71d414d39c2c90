#pragma once

#include "deja_view/features/types.hpp"
#include "deja_view/vocabulary/vocabulary_tree.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace deja_view::internal {

constexpr int kMaxChildren = 255;
constexpr int kMaxLevels = 32;
constexpr std::uint64_t kMaxNodes = (std::uint64_t{1} << 31) - 2;
constexpr float kMaxWeight = 30;  ///< an idf is a logarithm: no collection has e^30 images
constexpr std::size_t kSectionAlignment = 64;

/// Where a node leads. Nodes are numbered breadth first, 0 is the root, so that the children of a
/// node are contiguous and come after it.
struct NodeLink {
  std::uint32_t first = 0;  ///< first child, or the word of a leaf
  std::uint32_t count = 0;  ///< children; 0 for a leaf
};

/// What a file in foreign order needs to be written back as it was.
struct NodeSource {
  std::int32_t id = 0;      ///< the file's number of the node
  std::int32_t record = 0;  ///< its place among the file's records
  double weight = 0;
};

enum SectionId { kDescriptors, kLinks, kWeights, kWordNodes, kSources, kSectionCount };

struct FlatSection {
  std::uint64_t offset = 0;  ///< [byte] from the start of the file
  std::uint64_t size = 0;    ///< [byte]
  std::uint64_t hash = 0;    ///< Hash64 of the section
};

/// Start of a flat vocabulary file, little endian, followed by its sections at multiples of 64
/// bytes:
///   descriptors  Descriptor[nodes + 1]   the root's is 0
///   links        NodeLink[nodes + 1]
///   weights      float[words]            idf
///   word nodes   uint32[words]           the leaf of a word
///   sources      NodeSource[nodes + 1]   or empty, when nodes are in breadth-first order with ids
///   from 1
///                                        and weights are floats, 0 at inner nodes
struct FlatHeader {
  char magic[8] = {'D', 'V', 'V', 'O', 'C', 'A', 'B', '\n'};
  std::uint32_t version = 1;
  std::uint32_t header_size = sizeof(FlatHeader);
  char descriptor_name[16] = {};
  std::int32_t k = 0;
  std::int32_t levels = 0;
  std::int32_t scoring = 0;
  std::int32_t weighting = 0;
  std::uint64_t node_count = 0;  ///< without the root
  std::uint64_t word_count = 0;
  std::uint64_t file_size = 0;
  std::uint64_t identity = 0;
  FlatSection sections[kSectionCount];
  std::uint64_t header_hash = 0;  ///< Hash64 of everything before
};
static_assert(std::is_trivially_copyable_v<FlatHeader> && sizeof(FlatHeader) == 208);

/// A flat vocabulary in memory, checked: everything that a descent follows is within bounds.
struct FlatView {
  const FlatHeader* header = nullptr;
  const Descriptor* descriptors = nullptr;
  const NodeLink* links = nullptr;
  const float* weights = nullptr;
  const std::uint32_t* word_nodes = nullptr;
  const NodeSource* sources = nullptr;  ///< null when the section is empty
};

/// How much of a flat file is checked.
enum class FlatCheck {
  kStructure,  ///< header, links and words: enough never to read out of bounds
  kAll         ///< also the hashes of all sections
};

/// View of `size` bytes at `data`, which must be aligned to 32 bytes. Throws InputError that names
/// `source` and the field when they are not a sound vocabulary.
FlatView ViewFlat(const void* data, std::size_t size, const std::string& source, FlatCheck check);

/// The tree as a flat file's bytes. Throws InputError as Vocabulary::FromTree does.
std::vector<Descriptor> BuildFlat(const VocabularyTree& tree, const std::string& source);

/// The other way round; nodes in the order of `sources` where there are any.
VocabularyTree UnbuildFlat(const FlatView& view);

}  // namespace deja_view::internal
