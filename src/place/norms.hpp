#pragma once

#include <cstdint>

#include "similarity.hpp"
#include "slot_sums.hpp"

namespace deja_view::internal {

/// Everything that shows one word.
struct WordSlots {
  SlotSet all;         ///< slots that show the word
  RepeatList repeats;  ///< those of them that show it more than once
};

/// |b|_1 = sum_i w_i b_i of every slot.
///
/// A running idf changes all weights with every entry that comes or goes. With w_i = log(N + 1) -
/// log df_i, |b|_1 = log(N + 1) sum_i b_i - sum_i b_i log df_i: N is one factor outside the sums,
/// and a word whose df changes adds the same number to the second sum of each slot that shows it.
class L1Norms {
 public:
  using Sum = std::uint32_t;

  void Resize(std::uint32_t slots);
  void Set(std::uint32_t slot, const WordWeights& weights, const BowVector& bow);
  void Clear(std::uint32_t slot);

  /// log df of a word went from `before` to `after`. To be followed by Finish before sets change.
  void ChangeLogDf(const WordSlots& word, std::int32_t before, std::int32_t after);
  void Finish();

  std::uint64_t Get(std::uint32_t slot, const WordWeights& weights) const {
    // Frozen: the collection's logarithm is 0 and log_sums_ holds the negative norm.
    return static_cast<std::uint32_t>(weights.log_collection()) * count_sums_[slot] -
           log_sums_[slot];
  }

  std::size_t memory_bytes() const;

 private:
  SlotSums<Sum> count_sums_{0};
  SlotSums<Sum> log_sums_{0};  // modulo 2^32, as the difference is below
};

/// |b|_2^2 = sum_i (w_i b_i)^2 of every slot; as L1Norms with
/// |b|_2^2 = log(N + 1)^2 sum b_i^2 - 2 log(N + 1) sum b_i^2 log df_i + sum b_i^2 (log df_i)^2.
class SquaredNorms {
 public:
  using Sum = std::uint64_t;

  void Resize(std::uint32_t slots);
  void Set(std::uint32_t slot, const WordWeights& weights, const BowVector& bow);
  void Clear(std::uint32_t slot);
  void ChangeLogDf(const WordSlots& word, std::int32_t before, std::int32_t after);
  void Finish();

  std::uint64_t Get(std::uint32_t slot, const WordWeights& weights) const {
    const auto log_collection = static_cast<std::uint64_t>(weights.log_collection());
    return log_collection * (log_collection * count_sums_[slot] - 2 * log_sums_[slot]) +
           squared_log_sums_[slot];
  }

  std::size_t memory_bytes() const;

 private:
  SlotSums<Sum> count_sums_{0};
  SlotSums<Sum> log_sums_{0};
  SlotSums<Sum> squared_log_sums_{0};  // frozen: the norm itself
};

}  // namespace deja_view::internal
