#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/vocabulary/vocabulary_files.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <unordered_map>
#include <vector>

#include "mapped_file.hpp"

namespace deja_view {
namespace {

// The file's own structs, without padding.
struct VinsHeader {
  std::int32_t k, levels, scoring, weighting, nodes, words;
};
struct VinsNode {
  std::int32_t id, parent;
  double weight;
  std::uint64_t descriptor[4];
};
struct VinsWord {
  std::int32_t node, word;
};
static_assert(sizeof(VinsHeader) == 24 && sizeof(VinsNode) == 48 && sizeof(VinsWord) == 8);

template <typename T>
T Get(const void* data, std::size_t offset) {
  T value;
  std::memcpy(&value, static_cast<const char*>(data) + offset, sizeof(T));
  return value;
}

template <typename T>
void Put(std::ostream& stream, const T& value) {
  stream.write(reinterpret_cast<const char*>(&value), sizeof(T));
}

VinsHeader ReadHeader(const internal::MappedFile& file, const std::string& path) {
  if (file.size() < sizeof(VinsHeader)) {
    ThrowInputError("{}: header: {} bytes, expected {}", path, file.size(), sizeof(VinsHeader));
  }
  const auto header = Get<VinsHeader>(file.data(), 0);
  if (header.nodes < 1) {
    ThrowInputError("{}: nNodes: is {}, expected at least 1", path, header.nodes);
  }
  if (header.words < 1 || header.words > header.nodes) {
    ThrowInputError(
        "{}: nWords: is {}, expected 1 to {} (nNodes)", path, header.words, header.nodes);
  }
  const std::size_t expected = sizeof(VinsHeader) + std::size_t(header.nodes) * sizeof(VinsNode) +
                               std::size_t(header.words) * sizeof(VinsWord);
  if (file.size() != expected) {
    ThrowInputError("{}: size: {} bytes, but nNodes = {} and nWords = {} make {}",
                    path,
                    file.size(),
                    header.nodes,
                    header.words,
                    expected);
  }
  return header;
}

// Index of the record of each node id. The ids are those of a file: any numbers, so not an array.
using RecordOfId = std::unordered_map<std::int32_t, std::int32_t>;

}  // namespace

VocabularyTree ReadVinsVocabulary(const std::filesystem::path& path) {
  const std::string name = path.string();
  const internal::MappedFile file(path);
  const VinsHeader header = ReadHeader(file, name);
  VocabularyTree tree;
  tree.k = header.k;
  tree.levels = header.levels;
  tree.scoring = header.scoring;
  tree.weighting = header.weighting;
  tree.descriptor_name = "brief";
  tree.nodes.resize(header.nodes);

  RecordOfId records;
  records.reserve(tree.nodes.size());
  std::vector<std::int32_t> parents(tree.nodes.size());
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    const auto record = Get<VinsNode>(file.data(), sizeof(VinsHeader) + i * sizeof(VinsNode));
    VocabularyNode& node = tree.nodes[i];
    node.id = record.id;
    node.weight = record.weight;
    std::copy(
        std::begin(record.descriptor), std::end(record.descriptor), node.descriptor.words.begin());
    parents[i] = record.parent;
    if (record.id == 0 || !records.emplace(record.id, static_cast<std::int32_t>(i)).second) {
      ThrowInputError(
          "{}: nodeId: {} in record {} is the root's or given twice", name, record.id, i);
    }
  }
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    if (parents[i] == 0) {
      tree.nodes[i].parent = VocabularyNode::kRoot;
      continue;
    }
    const auto parent = records.find(parents[i]);
    if (parent == records.end()) {
      ThrowInputError(
          "{}: parentId: {} of node {} does not exist", name, parents[i], tree.nodes[i].id);
    }
    tree.nodes[i].parent = parent->second;
  }
  const std::size_t words_at = sizeof(VinsHeader) + tree.nodes.size() * sizeof(VinsNode);
  for (std::int32_t i = 0; i < header.words; ++i) {
    const auto record = Get<VinsWord>(file.data(), words_at + std::size_t(i) * sizeof(VinsWord));
    const auto node = records.find(record.node);
    if (node == records.end()) {
      ThrowInputError("{}: nodeId: {} of word {} does not exist", name, record.node, record.word);
    }
    if (tree.nodes[node->second].word != VocabularyNode::kNoWord || record.word < 0) {
      ThrowInputError("{}: wordId: {} for node {}, expected one word per leaf, counting from 0",
                      name,
                      record.word,
                      record.node);
    }
    tree.nodes[node->second].word = record.word;
  }
  return tree;
}

void WriteVinsVocabulary(const std::filesystem::path& path, const VocabularyTree& tree) {
  std::vector<VinsWord> words;
  for (const VocabularyNode& node : tree.nodes) {
    if (node.word != VocabularyNode::kNoWord) {
      words.push_back({node.id, node.word});
    }
  }
  std::sort(words.begin(), words.end(), [](const VinsWord& a, const VinsWord& b) {
    return a.word < b.word;
  });
  WriteFileAtomically(path, [&](std::ostream& stream) {
    Put(stream,
        VinsHeader{tree.k,
                   tree.levels,
                   tree.scoring,
                   tree.weighting,
                   static_cast<std::int32_t>(tree.nodes.size()),
                   static_cast<std::int32_t>(words.size())});
    for (const VocabularyNode& node : tree.nodes) {
      VinsNode record{};
      record.id = node.id;
      record.parent = node.parent == VocabularyNode::kRoot ? 0 : tree.nodes[node.parent].id;
      record.weight = node.weight;
      std::copy(node.descriptor.words.begin(), node.descriptor.words.end(), record.descriptor);
      Put(stream, record);
    }
    for (const VinsWord& word : words) {
      Put(stream, word);
    }
  });
}

}  // namespace deja_view
