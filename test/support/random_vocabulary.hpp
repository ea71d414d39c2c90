#pragma once

#include "deja_view/features/types.hpp"
#include "deja_view/vocabulary/bow_vector.hpp"
#include "deja_view/vocabulary/vocabulary_tree.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace deja_view::test {

inline Descriptor RandomDescriptor(std::mt19937_64* rng) {
  Descriptor descriptor;
  for (std::uint64_t& word : descriptor.words) {
    word = (*rng)();
  }
  return descriptor;
}

/// `descriptor` with about `bits` bits turned over.
inline Descriptor Disturb(Descriptor descriptor, int bits, std::mt19937_64* rng) {
  for (int i = 0; i < bits; ++i) {
    const std::uint64_t bit = (*rng)() % 256;
    descriptor.words[bit / 64] ^= std::uint64_t{1} << (bit % 64);
  }
  return descriptor;
}

/// A tree with random descriptors and weights in [0, 8], nodes breadth first. One node in
/// `leaf_every` above the last level is a leaf already (0: none).
inline VocabularyTree RandomTree(int k, int levels, std::uint64_t seed, int leaf_every = 0) {
  std::mt19937_64 rng(seed);
  VocabularyTree tree;
  tree.k = k;
  tree.levels = levels;
  std::vector<std::int32_t> parents = {VocabularyNode::kRoot};
  std::int32_t words = 0;
  for (int level = 1; level <= levels; ++level) {
    std::vector<std::int32_t> inner;
    for (const std::int32_t parent : parents) {
      for (int child = 0; child < k; ++child) {
        const auto index = static_cast<std::int32_t>(tree.nodes.size());
        VocabularyNode node;
        node.id = index + 1;
        node.parent = parent;
        node.descriptor = RandomDescriptor(&rng);
        if (level == levels || (leaf_every > 0 && rng() % leaf_every == 0)) {
          node.word = words++;
          node.weight = static_cast<float>(rng() % 8000) / 1000.0F;
        } else {
          inner.push_back(index);
        }
        tree.nodes.push_back(node);
      }
    }
    parents = inner;
  }
  return tree;
}

/// An image's words, drawn with a skew: word w with a probability that falls like 1 / (w + offset).
inline BowVector RandomBow(std::size_t descriptors, std::uint32_t words, std::mt19937_64* rng) {
  const double offset = words / 50.0;
  std::vector<std::uint32_t> counts(words, 0);
  for (std::size_t i = 0; i < descriptors; ++i) {
    const double u = static_cast<double>((*rng)() >> 11U) * 0x1p-53;
    const double word = offset * (std::pow((words + offset) / offset, u) - 1);
    ++counts[std::min<std::uint32_t>(words - 1, static_cast<std::uint32_t>(word))];
  }
  BowVector bow;
  bow.descriptor_count = static_cast<std::uint32_t>(descriptors);
  for (std::uint32_t word = 0; word < words; ++word) {
    if (counts[word] > 0) {
      bow.entries.push_back({word, counts[word]});
    }
  }
  return bow;
}

}  // namespace deja_view::test
