#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"
#include "deja_view/base/quote.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

#include "flat_format.hpp"

namespace deja_view::internal {
namespace {

constexpr std::array<const char*, kSectionCount> kSectionNames = {
    "descriptors", "links", "weights", "word_nodes", "sources"};

void CheckHeader(const FlatHeader& header, std::size_t size, const std::string& source) {
  const FlatHeader expected;
  if (std::memcmp(header.magic, expected.magic, sizeof(header.magic)) != 0) {
    ThrowInputError("{}: magic: not a vocabulary of this package", source);
  }
  if (header.version != expected.version) {
    ThrowInputError("{}: version: is {}, expected {}", source, header.version, expected.version);
  }
  if (header.header_size != expected.header_size) {
    ThrowInputError(
        "{}: header_size: is {}, expected {}", source, header.header_size, expected.header_size);
  }
  if (header.header_hash != Hash64(&header, offsetof(FlatHeader, header_hash))) {
    ThrowInputError("{}: header_hash: the header is damaged", source);
  }
  if (header.file_size != size) {
    ThrowInputError(
        "{}: file_size: is {} bytes, the header says {}", source, size, header.file_size);
  }
}

// The hash guards against damage, these against a writer that went wrong.
void CheckFields(const FlatHeader& header, const std::string& source) {
  const std::string_view name(header.descriptor_name,
                              ::strnlen(header.descriptor_name, sizeof(header.descriptor_name)));
  if (name != "brief" && name != "orb") {
    ThrowInputError("{}: descriptor_name: is {}, expected brief or orb", source, Quote(name));
  }
  if (header.k < 1 || header.k > kMaxChildren) {
    ThrowInputError("{}: k: is {}, expected 1 to {}", source, header.k, kMaxChildren);
  }
  if (header.levels < 1 || header.levels > kMaxLevels) {
    ThrowInputError("{}: levels: is {}, expected 1 to {}", source, header.levels, kMaxLevels);
  }
  if (header.node_count < 1 || header.node_count > kMaxNodes) {
    ThrowInputError(
        "{}: node_count: is {}, expected 1 to {}", source, header.node_count, kMaxNodes);
  }
  if (header.word_count < 1 || header.word_count > header.node_count) {
    ThrowInputError("{}: word_count: is {}, expected 1 to {} (nodes)",
                    source,
                    header.word_count,
                    header.node_count);
  }
}

void CheckSections(const FlatHeader& header, const std::string& source) {
  const std::uint64_t slots = header.node_count + 1;
  const std::array<std::uint64_t, kSectionCount> sizes = {slots * sizeof(Descriptor),
                                                          slots * sizeof(NodeLink),
                                                          header.word_count * sizeof(float),
                                                          header.word_count * sizeof(std::uint32_t),
                                                          slots * sizeof(NodeSource)};
  for (int i = 0; i < kSectionCount; ++i) {
    const FlatSection& section = header.sections[i];
    const bool may_be_empty = i == kSources;
    if (section.size != sizes[i] && !(may_be_empty && section.size == 0)) {
      ThrowInputError(
          "{}: {}.size: is {}, expected {}", source, kSectionNames[i], section.size, sizes[i]);
    }
    if (section.offset % kSectionAlignment != 0 || section.offset < sizeof(FlatHeader) ||
        section.offset > header.file_size || section.size > header.file_size - section.offset) {
      ThrowInputError("{}: {}.offset: {} with {} bytes does not lie within the file",
                      source,
                      kSectionNames[i],
                      section.offset,
                      section.size);
    }
  }
}

// Every node but the root is the child of exactly one node before it, so that each descent ends.
void CheckLinks(const FlatView& view, const std::string& source) {
  const std::uint64_t slots = view.header->node_count + 1;
  const std::uint64_t words = view.header->word_count;
  std::uint64_t next_child = 1;
  std::uint64_t leaves = 0;
  for (std::uint64_t node = 0; node < slots; ++node) {
    const NodeLink link = view.links[node];
    if (link.count == 0) {
      if (link.first >= words || view.word_nodes[link.first] != node) {
        ThrowInputError("{}: links: word of leaf {} is {}", source, node, link.first);
      }
      ++leaves;
      continue;
    }
    if (link.first != next_child || link.first <= node ||
        link.count > static_cast<std::uint32_t>(view.header->k) ||
        link.first + std::uint64_t{link.count} > slots) {
      ThrowInputError("{}: links: node {} has children {} to {}",
                      source,
                      node,
                      link.first,
                      link.first + std::uint64_t{link.count});
    }
    next_child += link.count;
  }
  if (next_child != slots || leaves != words) {
    ThrowInputError("{}: links: reach {} of {} nodes and {} of {} words",
                    source,
                    next_child - 1,
                    slots - 1,
                    leaves,
                    words);
  }
}

bool IsWeight(float weight) {
  return weight >= 0 && weight <= kMaxWeight;
}

void CheckWeights(const FlatView& view, const std::string& source) {
  // Counted rather than left at the first, so that the compiler does many at a time.
  std::uint64_t sound = 0;
  for (std::uint64_t word = 0; word < view.header->word_count; ++word) {
    sound += IsWeight(view.weights[word]) ? 1 : 0;
  }
  for (std::uint64_t word = 0; sound != view.header->word_count; ++word) {
    if (!IsWeight(view.weights[word])) {
      ThrowInputError("{}: weights: of word {} is {}, expected 0 to {}",
                      source,
                      word,
                      view.weights[word],
                      kMaxWeight);
    }
  }
}

// The records of a file are a permutation.
void CheckSources(const FlatView& view, const std::string& source) {
  if (view.sources == nullptr) {
    return;
  }
  const std::uint64_t nodes = view.header->node_count;
  std::vector<bool> is_taken(nodes, false);
  for (std::uint64_t node = 1; node <= nodes; ++node) {
    const std::int32_t record = view.sources[node].record;
    if (record < 0 || static_cast<std::uint64_t>(record) >= nodes || is_taken[record]) {
      ThrowInputError("{}: sources: record of node {} is {}", source, node, record);
    }
    is_taken[record] = true;
  }
}

void CheckHashes(const FlatHeader& header, const void* data, const std::string& source) {
  for (int i = 0; i < kSectionCount; ++i) {
    const FlatSection& section = header.sections[i];
    const char* begin = static_cast<const char*>(data) + section.offset;
    if (Hash64(begin, section.size) != section.hash) {
      ThrowInputError("{}: {}.hash: the section is damaged", source, kSectionNames[i]);
    }
  }
}

}  // namespace

FlatView ViewFlat(const void* data, std::size_t size, const std::string& source, FlatCheck check) {
  if (size < sizeof(FlatHeader)) {
    ThrowInputError("{}: header: {} bytes, expected {}", source, size, sizeof(FlatHeader));
  }
  const char* begin = static_cast<const char*>(data);
  FlatView view;
  view.header = static_cast<const FlatHeader*>(data);
  const FlatHeader& header = *view.header;
  CheckHeader(header, size, source);
  CheckFields(header, source);
  CheckSections(header, source);
  const auto section = [&](SectionId id) -> const void* {
    return begin + header.sections[id].offset;
  };
  view.descriptors = static_cast<const Descriptor*>(section(kDescriptors));
  view.links = static_cast<const NodeLink*>(section(kLinks));
  view.weights = static_cast<const float*>(section(kWeights));
  view.word_nodes = static_cast<const std::uint32_t*>(section(kWordNodes));
  if (header.sections[kSources].size > 0) {
    view.sources = static_cast<const NodeSource*>(section(kSources));
  }
  if (check == FlatCheck::kAll) {
    CheckHashes(header, data, source);
  }
  CheckLinks(view, source);
  CheckWeights(view, source);
  CheckSources(view, source);
  return view;
}

}  // namespace deja_view::internal
