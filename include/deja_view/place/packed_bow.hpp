#pragma once

#include "deja_view/place/word_scoring.hpp"
#include "deja_view/vocabulary/bow_vector.hpp"

#include <cstdint>
#include <vector>

namespace deja_view {

/// An image's words, ten bytes each, as map files keep them.
struct PackedBow {
  std::vector<WordId> words;          ///< sorted, each once
  std::vector<std::uint16_t> counts;  ///< per word
  std::vector<float> weights;         ///< per word; none where words are not weighted
  std::uint32_t descriptor_count = 0;
};

/// `weighted` are `bow`'s words with their weights, or none.
PackedBow Pack(const BowVector& bow, const WeightedBow& weighted);
/// The bag of words that was packed.
BowVector CountsOf(const PackedBow& packed);

}  // namespace deja_view
