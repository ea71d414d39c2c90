#include "norms.hpp"

#include <algorithm>

namespace deja_view::internal {
void L1Norms::Resize(std::uint32_t slots) {
  count_sums_.Resize(slots);
  log_sums_.Resize(slots);
}

void L1Norms::Set(std::uint32_t slot, const WordWeights& weights, const BowVector& bow) {
  Clear(slot);
  if (weights.mode() == IdfMode::kFrozen) {
    log_sums_[slot] = 0U - static_cast<std::uint32_t>(L1Norm(weights, bow));
    return;
  }
  for (const WordCount& entry : bow.entries) {
    const std::uint32_t count = std::min(entry.count, kMaxCount);
    count_sums_[slot] += count;
    log_sums_[slot] += count * static_cast<std::uint32_t>(weights.log_df(entry.word));
  }
}

void L1Norms::Clear(std::uint32_t slot) {
  count_sums_[slot] = 0;
  log_sums_[slot] = 0;
}

void L1Norms::ChangeLogDf(const WordSlots& word, std::int32_t before, std::int32_t after) {
  const auto change = static_cast<Sum>(after - before);
  log_sums_.Add(word.all, change);
  for (std::uint32_t i = 0; i < word.repeats.size(); ++i) {
    log_sums_[word.repeats.slot(i)] += change * (word.repeats.count(i) - 1);
  }
}

void L1Norms::Finish() {
  log_sums_.Finish();
}

std::size_t L1Norms::memory_bytes() const {
  return count_sums_.memory_bytes() + log_sums_.memory_bytes();
}

void SquaredNorms::Resize(std::uint32_t slots) {
  count_sums_.Resize(slots);
  log_sums_.Resize(slots);
  squared_log_sums_.Resize(slots);
}

void SquaredNorms::Set(std::uint32_t slot, const WordWeights& weights, const BowVector& bow) {
  Clear(slot);
  if (weights.mode() == IdfMode::kFrozen) {
    squared_log_sums_[slot] = SquaredNorm(weights, bow);
    return;
  }
  for (const WordCount& entry : bow.entries) {
    const std::uint64_t count = std::min(entry.count, kMaxCount);
    const auto log_df = static_cast<std::uint64_t>(weights.log_df(entry.word));
    count_sums_[slot] += count * count;
    log_sums_[slot] += count * count * log_df;
    squared_log_sums_[slot] += count * count * log_df * log_df;
  }
}

void SquaredNorms::Clear(std::uint32_t slot) {
  count_sums_[slot] = 0;
  log_sums_[slot] = 0;
  squared_log_sums_[slot] = 0;
}

void SquaredNorms::ChangeLogDf(const WordSlots& word, std::int32_t before, std::int32_t after) {
  const auto a = static_cast<Sum>(before);
  const auto b = static_cast<Sum>(after);
  log_sums_.Add(word.all, b - a);
  squared_log_sums_.Add(word.all, b * b - a * a);
  for (std::uint32_t i = 0; i < word.repeats.size(); ++i) {
    const Sum count = word.repeats.count(i);
    const std::uint32_t slot = word.repeats.slot(i);
    log_sums_[slot] += (count * count - 1) * (b - a);
    squared_log_sums_[slot] += (count * count - 1) * (b * b - a * a);
  }
}

void SquaredNorms::Finish() {
  log_sums_.Finish();
  squared_log_sums_.Finish();
}

std::size_t SquaredNorms::memory_bytes() const {
  return count_sums_.memory_bytes() + log_sums_.memory_bytes() + squared_log_sums_.memory_bytes();
}

}  // namespace deja_view::internal
