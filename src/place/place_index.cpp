#include "place_index.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace deja_view::internal {

template <typename Norms>
PlaceIndex<Norms>::PlaceIndex(IdfMode mode, const Vocabulary& vocabulary)
    : weights_(mode, vocabulary), words_(vocabulary.word_count()) {}

template <typename Norms>
std::uint32_t PlaceIndex<Norms>::TakeSlot() {
  if (!free_slots_.empty()) {
    const std::uint32_t slot = free_slots_.back();
    free_slots_.pop_back();
    return slot;
  }
  const auto slot = static_cast<std::uint32_t>(slots_.size());
  DEJA_VIEW_CHECK_OP(slot, <, kMaxSlots);
  slots_.emplace_back();
  norms_.Resize(slot + 1);
  return slot;
}

// With a running idf, entries that show these words get other norms.
template <typename Norms>
void PlaceIndex<Norms>::ChangeDf(const BowVector& bow, std::int64_t change) {
  weights_.SetEntries(static_cast<std::uint32_t>(static_cast<std::int64_t>(size()) + change));
  for (const WordCount& entry : bow.entries) {
    const WordSlots& word = words_[entry.word];
    const std::int32_t before = weights_.log_df(entry.word);
    weights_.SetDf(entry.word, static_cast<std::uint32_t>(word.all.size() + change));
    norms_.ChangeLogDf(word, before, weights_.log_df(entry.word));
  }
  norms_.Finish();
}

template <typename Norms>
void PlaceIndex<Norms>::Add(int id, int tag, const BowVector& bow) {
  if (weights_.mode() == IdfMode::kRunning) {
    ChangeDf(bow, 1);
  }
  const std::uint32_t slot = TakeSlot();
  SlotEntry& entry = slots_[slot];
  entry.id = id;
  entry.tag = tag;
  entry.is_used = true;
  entry.bow = bow;
  norms_.Set(slot, weights_, bow);
  const auto slots = static_cast<std::uint32_t>(slots_.size());
  for (const WordCount& word : bow.entries) {
    words_[word.word].all.Add(slot, slots);
    if (word.count > 1) {
      words_[word.word].repeats.Add(slot, std::min(word.count, kMaxCount));
    }
  }
  by_key_[{id, tag}] = slot;
}

template <typename Norms>
void PlaceIndex<Norms>::RemoveSlot(std::uint32_t slot) {
  const BowVector bow = std::move(slots_[slot].bow);
  for (const WordCount& word : bow.entries) {
    words_[word.word].all.Remove(slot);
    if (word.count > 1) {
      words_[word.word].repeats.Remove(slot);
    }
  }
  slots_[slot] = SlotEntry{};
  norms_.Clear(slot);
  free_slots_.push_back(slot);
  if (weights_.mode() == IdfMode::kRunning) {
    ChangeDf(bow, 0);
  }
}

template <typename Norms>
bool PlaceIndex<Norms>::Remove(int id) {
  const auto begin = by_key_.lower_bound({id, std::numeric_limits<int>::min()});
  const auto end = by_key_.upper_bound({id, std::numeric_limits<int>::max()});
  std::vector<std::uint32_t> slots;
  for (auto entry = begin; entry != end; ++entry) {
    slots.push_back(entry->second);
  }
  by_key_.erase(begin, end);
  for (const std::uint32_t slot : slots) {
    RemoveSlot(slot);
  }
  return !slots.empty();
}

template <typename Norms>
bool PlaceIndex<Norms>::Remove(int id, int tag) {
  const auto entry = by_key_.find({id, tag});
  if (entry == by_key_.end()) {
    return false;
  }
  const std::uint32_t slot = entry->second;
  by_key_.erase(entry);
  RemoveSlot(slot);
  return true;
}

template <typename Norms>
std::size_t PlaceIndex<Norms>::memory_bytes() const {
  // A node of a std::map: three pointers, a colour and the value.
  constexpr std::size_t kMapNode = 4 * sizeof(void*) + sizeof(std::pair<const Key, std::uint32_t>);
  std::size_t bytes = weights_.memory_bytes() + norms_.memory_bytes() +
                      words_.capacity() * sizeof(WordSlots) +
                      slots_.capacity() * sizeof(SlotEntry) + by_key_.size() * kMapNode;
  for (const WordSlots& word : words_) {
    bytes += word.all.memory_bytes() + word.repeats.memory_bytes();
  }
  for (const SlotEntry& slot : slots_) {
    bytes += slot.bow.entries.capacity() * sizeof(WordCount);
  }
  return bytes;
}

template class PlaceIndex<L1Norms>;
template class PlaceIndex<SquaredNorms>;

}  // namespace deja_view::internal
