#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"
#include "deja_view/base/quote.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

#include "flat_format.hpp"

namespace deja_view::internal {
namespace {

constexpr std::uint32_t kNotSeen = 0xffffffffU;

// Breadth-first numbering: order[i] is the record (index into tree.nodes) of flat node i + 1.
struct Layout {
  std::vector<std::uint32_t> order;
  std::vector<NodeLink> links;  // words are still missing
};

void CheckTree(const VocabularyTree& tree, const std::string& source) {
  if (tree.descriptor_name != "brief" && tree.descriptor_name != "orb") {
    ThrowInputError(
        "{}: descriptor_name: is {}, expected brief or orb", source, Quote(tree.descriptor_name));
  }
  if (tree.k < 1 || tree.k > kMaxChildren) {
    ThrowInputError("{}: k: is {}, expected 1 to {}", source, tree.k, kMaxChildren);
  }
  if (tree.levels < 1 || tree.levels > kMaxLevels) {
    ThrowInputError("{}: levels: is {}, expected 1 to {}", source, tree.levels, kMaxLevels);
  }
  if (tree.nodes.empty() || tree.nodes.size() > kMaxNodes) {
    ThrowInputError("{}: nodes: {}, expected 1 to {}", source, tree.nodes.size(), kMaxNodes);
  }
  for (const VocabularyNode& node : tree.nodes) {
    if (node.parent != VocabularyNode::kRoot &&
        (node.parent < 0 || node.parent >= static_cast<std::int64_t>(tree.nodes.size()))) {
      ThrowInputError("{}: parent: of node {} does not exist", source, node.id);
    }
    if (!std::isfinite(node.weight) || node.weight < 0 || node.weight > double{kMaxWeight}) {
      ThrowInputError("{}: weight: of node {} is {}, expected 0 to {}",
                      source,
                      node.id,
                      node.weight,
                      kMaxWeight);
    }
  }
}

// Children of each node, in the order of the records: counting sort by parent.
struct Children {
  explicit Children(const VocabularyTree& tree)
      : begin(tree.nodes.size() + 2, 0), records(tree.nodes.size()) {
    for (const VocabularyNode& node : tree.nodes) {
      ++begin[Slot(node.parent) + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
      records[next[Slot(tree.nodes[i].parent)]++] = static_cast<std::uint32_t>(i);
    }
  }

  static std::size_t Slot(std::int32_t parent) { return static_cast<std::size_t>(parent + 1); }

  std::vector<std::uint32_t> begin;    // of slot parent + 1, so that the root's is 0
  std::vector<std::uint32_t> records;  // indices into tree.nodes
};

Layout LayOut(const VocabularyTree& tree, const std::string& source) {
  const Children children(tree);
  Layout layout;
  layout.order.reserve(tree.nodes.size());
  layout.links.reserve(tree.nodes.size() + 1);
  std::size_t level_end = 1;  // flat node at which the next level starts
  int level = 0;
  for (std::size_t node = 0; node <= layout.order.size(); ++node) {
    if (node == level_end) {
      ++level;
      level_end = layout.order.size() + 1;
    }
    const std::size_t slot = node == 0 ? 0 : layout.order[node - 1] + std::size_t{1};
    const std::uint32_t count = children.begin[slot + 1] - children.begin[slot];
    if (count > static_cast<std::uint32_t>(tree.k)) {
      ThrowInputError("{}: k: node {} has {} children, more than {}",
                      source,
                      slot == 0 ? 0 : tree.nodes[slot - 1].id,
                      count,
                      tree.k);
    }
    if (count > 0 && level >= tree.levels) {
      ThrowInputError("{}: levels: node {} is on level {} and has children, expected {} levels",
                      source,
                      slot == 0 ? 0 : tree.nodes[slot - 1].id,
                      level,
                      tree.levels);
    }
    layout.links.push_back({static_cast<std::uint32_t>(layout.order.size() + 1), count});
    layout.order.insert(layout.order.end(),
                        children.records.begin() + children.begin[slot],
                        children.records.begin() + children.begin[slot + 1]);
  }
  if (layout.order.size() != tree.nodes.size()) {
    ThrowInputError("{}: parent: {} of {} nodes have no way to the root",
                    source,
                    tree.nodes.size() - layout.order.size(),
                    tree.nodes.size());
  }
  return layout;
}

// Fills in the words of the leaves; returns the leaf of each word.
std::vector<std::uint32_t> AssignWords(const VocabularyTree& tree,
                                       const std::string& source,
                                       Layout* layout) {
  const auto leaves = static_cast<std::size_t>(
      std::count_if(layout->links.begin(), layout->links.end(), [](const NodeLink& link) {
        return link.count == 0;
      }));
  std::vector<std::uint32_t> word_nodes(leaves, kNotSeen);
  for (std::size_t i = 0; i < layout->order.size(); ++i) {
    const VocabularyNode& node = tree.nodes[layout->order[i]];
    NodeLink& link = layout->links[i + 1];
    if (link.count > 0) {
      if (node.word != VocabularyNode::kNoWord) {
        ThrowInputError(
            "{}: word: {} is at node {}, which has children", source, node.word, node.id);
      }
      continue;
    }
    if (node.word < 0 || static_cast<std::size_t>(node.word) >= leaves) {
      ThrowInputError("{}: word: of leaf {} is {}, expected 0 to {}",
                      source,
                      node.id,
                      node.word,
                      static_cast<std::int64_t>(leaves) - 1);
    }
    if (word_nodes[node.word] != kNotSeen) {
      ThrowInputError("{}: word: {} is given twice, again at node {}", source, node.word, node.id);
    }
    link.first = static_cast<std::uint32_t>(node.word);
    word_nodes[node.word] = static_cast<std::uint32_t>(i + 1);
  }
  return word_nodes;
}

// Nodes in breadth-first order with ids from 1 and weights that a float holds need no sources.
bool NeedsSources(const VocabularyTree& tree, const Layout& layout) {
  for (std::size_t i = 0; i < layout.order.size(); ++i) {
    const VocabularyNode& node = tree.nodes[i];
    const bool is_leaf = layout.links[i + 1].count == 0;
    const double kept = is_leaf ? double{static_cast<float>(node.weight)} : 0.0;
    if (layout.order[i] != i || node.id != static_cast<std::int64_t>(i + 1) ||
        node.weight != kept) {
      return true;
    }
  }
  return false;
}

// Lays sections one after another into a buffer.
class FlatWriter {
 public:
  FlatWriter() { Reserve(sizeof(FlatHeader)); }

  template <typename T>
  void Add(SectionId id, const std::vector<T>& values) {
    FlatSection& section = header.sections[id];
    section.offset = size_;
    section.size = values.size() * sizeof(T);
    section.hash = Hash64(values.data(), section.size);
    Reserve(section.size);
    if (section.size > 0) {
      std::memcpy(Bytes() + section.offset, values.data(), section.size);
    }
  }

  std::vector<Descriptor> Finish() {
    header.file_size = size_;
    header.identity = Identity();
    header.header_hash = Hash64(&header, offsetof(FlatHeader, header_hash));
    std::memcpy(Bytes(), &header, sizeof(header));
    return std::move(buffer_);
  }

  FlatHeader header;

 private:
  char* Bytes() { return reinterpret_cast<char*>(buffer_.data()); }

  void Reserve(std::size_t bytes) {
    size_ += (bytes + kSectionAlignment - 1) / kSectionAlignment * kSectionAlignment;
    buffer_.resize(size_ / sizeof(Descriptor));
  }

  // Everything that words and weights depend on, not the order and ids of a file's records.
  std::uint64_t Identity() const {
    const std::array<std::uint64_t, 4> parts = {
        header.sections[kDescriptors].hash,
        header.sections[kLinks].hash,
        header.sections[kWeights].hash,
        Hash64(header.descriptor_name, sizeof(header.descriptor_name))};
    return Hash64(parts.data(), sizeof(parts));
  }

  std::size_t size_ = 0;
  std::vector<Descriptor> buffer_;
};

}  // namespace

std::vector<Descriptor> BuildFlat(const VocabularyTree& tree, const std::string& source) {
  CheckTree(tree, source);
  Layout layout = LayOut(tree, source);
  const std::vector<std::uint32_t> word_nodes = AssignWords(tree, source, &layout);
  const std::size_t nodes = tree.nodes.size();
  std::vector<Descriptor> descriptors(nodes + 1);
  std::vector<float> weights(word_nodes.size());
  std::vector<NodeSource> sources(NeedsSources(tree, layout) ? nodes + 1 : 0);
  for (std::size_t i = 0; i < nodes; ++i) {
    const VocabularyNode& node = tree.nodes[layout.order[i]];
    descriptors[i + 1] = node.descriptor;
    if (node.word != VocabularyNode::kNoWord) {
      weights[node.word] = static_cast<float>(node.weight);
    }
    if (!sources.empty()) {
      sources[i + 1] = {node.id, static_cast<std::int32_t>(layout.order[i]), node.weight};
    }
  }

  FlatWriter writer;
  FlatHeader& header = writer.header;
  tree.descriptor_name.copy(header.descriptor_name, sizeof(header.descriptor_name) - 1);
  header.k = tree.k;
  header.levels = tree.levels;
  header.scoring = tree.scoring;
  header.weighting = tree.weighting;
  header.node_count = nodes;
  header.word_count = word_nodes.size();
  writer.Add(kDescriptors, descriptors);
  writer.Add(kLinks, layout.links);
  writer.Add(kWeights, weights);
  writer.Add(kWordNodes, word_nodes);
  writer.Add(kSources, sources);
  return writer.Finish();
}

VocabularyTree UnbuildFlat(const FlatView& view) {
  const FlatHeader& header = *view.header;
  VocabularyTree tree;
  tree.k = header.k;
  tree.levels = header.levels;
  tree.scoring = header.scoring;
  tree.weighting = header.weighting;
  tree.descriptor_name = header.descriptor_name;
  const std::size_t nodes = header.node_count;
  tree.nodes.resize(nodes);
  const auto record = [&](std::size_t node) {
    return view.sources != nullptr ? view.sources[node].record
                                   : static_cast<std::int32_t>(node - 1);
  };
  for (std::size_t i = 0; i <= nodes; ++i) {
    const NodeLink link = view.links[i];
    if (i > 0) {
      VocabularyNode& node = tree.nodes[record(i)];
      const bool is_leaf = link.count == 0;
      node.id = view.sources != nullptr ? view.sources[i].id : static_cast<std::int32_t>(i);
      node.word = is_leaf ? static_cast<std::int32_t>(link.first) : VocabularyNode::kNoWord;
      node.descriptor = view.descriptors[i];
      if (view.sources != nullptr) {
        node.weight = view.sources[i].weight;
      } else {
        node.weight = is_leaf ? double{view.weights[link.first]} : 0.0;
      }
    }
    for (std::uint32_t child = 0; child < link.count; ++child) {
      tree.nodes[record(link.first + child)].parent = i > 0 ? record(i) : VocabularyNode::kRoot;
    }
  }
  return tree;
}

}  // namespace deja_view::internal
