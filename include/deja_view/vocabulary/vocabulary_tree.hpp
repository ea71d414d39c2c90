#pragma once

#include "deja_view/features/types.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace deja_view {

/// One node of a vocabulary as its file tells it; the root has none.
struct VocabularyNode {
  static constexpr std::int32_t kRoot = -1;
  static constexpr std::int32_t kNoWord = -1;

  std::int32_t id = 0;          ///< the file's own number of the node, kept for writing it back
  std::int32_t parent = kRoot;  ///< index into VocabularyTree::nodes, or kRoot
  std::int32_t word = kNoWord;  ///< of a leaf; an inner node has kNoWord
  double weight = 0;            ///< idf of a leaf; of no meaning for an inner node, but kept
  Descriptor descriptor;        ///< the centroid

  friend bool operator==(const VocabularyNode& a, const VocabularyNode& b) {
    return a.id == b.id && a.parent == b.parent && a.word == b.word && a.weight == b.weight &&
           a.descriptor == b.descriptor;
  }
};

/// A vocabulary in the form in which files are read and written and training makes it. Nodes stand
/// in any order (that of the file); the children of a node are ordered as they stand here, and a
/// descent takes the first of equally near ones, as DBoW2 does.
struct VocabularyTree {
  int k = 10;                             ///< largest number of children
  int levels = 6;                         ///< largest depth of a leaf
  int scoring = 0;                        ///< DBoW2's ScoringType, 0 for L1; kept for writing
  int weighting = 0;                      ///< DBoW2's WeightingType, 0 for TF-IDF; kept for writing
  std::string descriptor_name = "brief";  ///< "brief" or "orb"
  std::vector<VocabularyNode> nodes;
};

}  // namespace deja_view
