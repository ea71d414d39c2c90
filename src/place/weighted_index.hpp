#pragma once

#include "deja_view/place/packed_bow.hpp"
#include "deja_view/place/word_scoring.hpp"
#include "deja_view/vocabulary/bow_vector.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "slot_set.hpp"

namespace deja_view::internal {

/// Weighted words, six bytes each: steps from word to word, and weights.
class PackedWords {
 public:
  /// Keeps the words whose weight is above 0.
  explicit PackedWords(const PackedBow& bow = {});

  /// Calls f(word, weight), words in their order.
  template <typename F>
  void ForEach(F f) const {
    WordId word = 0;
    const float* weight = weights_.data();
    for (const std::uint16_t step : steps_) {
      word += step;
      if (step != kLongStep) {
        f(word, *weight++);
      }
    }
  }

  std::size_t memory_bytes() const {
    return steps_.capacity() * sizeof(std::uint16_t) + weights_.capacity() * sizeof(float);
  }

 private:
  static constexpr std::uint16_t kLongStep = 0xffff;  ///< a step that ends at no word

  std::vector<std::uint16_t> steps_;
  std::vector<float> weights_;
};

/// Images by their weighted words: each word names the images (slots) that show it, each image its
/// words, so that few images need be compared word by word.
///
/// An image's weight of a word is its count times its idf, times a factor that differs little
/// between the image's words (its norm, and what WeighWords makes of it). With the largest of these
/// factors, `scale`, a.b <= scale_b sum_i a_i idf_i count_b,i: a sum of what the words add alone,
/// without reading a weight for each word and image. Bound sums in whole numbers; rounding is up.
class WeightedIndex {
 public:
  explicit WeightedIndex(std::shared_ptr<const Vocabulary> vocabulary);

  /// The slot that it takes, which was free. `bow` is weighted.
  std::uint32_t Add(const PackedBow& bow);
  /// The same as one Add after the other: many images at once find a word's slots in the cache.
  std::vector<std::uint32_t> AddAll(const std::vector<const PackedBow*>& images);
  void Remove(std::uint32_t slot);
  void Clear();

  std::uint32_t slot_count() const { return static_cast<std::uint32_t>(slots_.size()); }

  /// At least the dot product of every slot, as Dot computes it; 0 only where that is.
  std::vector<float> Bounds(const WeightedBow& query) const;

  /// The weight of every word of the vocabulary.
  std::vector<float> Spread(const WeightedBow& query) const;

  /// Sum over the slot's words in their order, in single precision. `query` from Spread.
  float Dot(std::uint32_t slot, const std::vector<float>& query) const;

  std::size_t memory_bytes() const;

 private:
  /// Everything that shows one word.
  struct Word {
    SlotSet all;      ///< slots that show the word,
    SlotSet twice;    ///< those of them that show it more than once,
    RepeatList more;  ///< and those of these that show it more than twice
  };

  std::uint32_t TakeSlot();
  void Fill(std::uint32_t slot, const PackedBow& bow);
  void Name(std::uint32_t slot, std::uint32_t slots, WordId id, std::uint32_t shown);
  void Prefetch(const WeightedBow& query, std::size_t i) const;

  std::shared_ptr<const Vocabulary> vocabulary_;
  std::vector<Word> words_;
  std::vector<PackedWords> slots_;
  std::vector<float> scales_;  ///< per slot
  std::vector<std::uint32_t> free_slots_;
};

}  // namespace deja_view::internal
