#pragma once

#include <cstdint>
#include <vector>

namespace deja_view {

using WordId = std::uint32_t;

/// One entry of a bag of words.
struct WordCount {
  WordId word = 0;
  std::uint32_t count = 0;  ///< how many descriptors of the image fell into the word

  friend bool operator==(const WordCount& a, const WordCount& b) {
    return a.word == b.word && a.count == b.count;
  }
};

/// Raw counts of one image's words, sorted by word, each word once. Weights (tf, idf) are applied
/// by the place database, so that a running idf never makes stored vectors stale.
struct BowVector {
  std::vector<WordCount> entries;
  std::uint32_t descriptor_count = 0;  ///< all descriptors of the image, also those of stop words
};

}  // namespace deja_view
