#include "weighted_index.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "similarity.hpp"
#include "slot_sums.hpp"

namespace deja_view::internal {
namespace {

// Of a word in Bounds: enough for bounds within a hundredth, and few bits are quick to sum up.
constexpr double kLargestWeight = 255;

std::uint32_t Counted(std::uint32_t count) {
  return std::min(count, kMaxCount);
}

/// Of a word by an image.
struct Mention {
  WordId word;
  std::uint32_t image;
  std::uint32_t count;
};

// Of `terms` numbers none of which is negative, added in single precision, and a few products.
double RoundingOf(std::size_t terms) {
  return 1.0 + static_cast<double>(terms + 8) * double{std::numeric_limits<float>::epsilon()};
}

}  // namespace

PackedWords::PackedWords(const PackedBow& bow) {
  std::size_t kept = 0;
  std::size_t long_steps = 0;
  WordId last = 0;
  for (std::size_t i = 0; i < bow.words.size(); ++i) {
    if (bow.weights[i] > 0) {
      ++kept;
      long_steps += (bow.words[i] - last) / kLongStep;
      last = bow.words[i];
    }
  }
  steps_.reserve(kept + long_steps);
  weights_.reserve(kept);
  last = 0;
  for (std::size_t i = 0; i < bow.words.size(); ++i) {
    if (bow.weights[i] > 0) {
      for (; bow.words[i] - last >= kLongStep; last += kLongStep) {
        steps_.push_back(kLongStep);
      }
      steps_.push_back(static_cast<std::uint16_t>(bow.words[i] - last));
      weights_.push_back(bow.weights[i]);
      last = bow.words[i];
    }
  }
}

WeightedIndex::WeightedIndex(std::shared_ptr<const Vocabulary> vocabulary)
    : vocabulary_(std::move(vocabulary)), words_(vocabulary_->word_count()) {}

std::uint32_t WeightedIndex::TakeSlot() {
  if (!free_slots_.empty()) {
    const std::uint32_t slot = free_slots_.back();
    free_slots_.pop_back();
    return slot;
  }
  DEJA_VIEW_CHECK_OP(slot_count(), <, kMaxSlots);
  slots_.emplace_back();
  scales_.push_back(0);
  return slot_count() - 1;
}

std::uint32_t WeightedIndex::Add(const PackedBow& bow) {
  DEJA_VIEW_CHECK_OP(bow.weights.size(), ==, bow.words.size());
  const std::uint32_t slot = TakeSlot();
  Fill(slot, bow);
  for (std::size_t i = 0; i < bow.words.size(); ++i) {
    if (bow.weights[i] > 0) {
      Name(slot, slot_count(), bow.words[i], bow.counts[i]);
    }
  }
  return slot;
}

void WeightedIndex::Fill(std::uint32_t slot, const PackedBow& bow) {
  double scale = 0;
  for (std::size_t i = 0; i < bow.words.size(); ++i) {
    if (bow.weights[i] > 0) {
      const std::uint32_t count = Counted(bow.counts[i]);
      scale = std::max(scale, bow.weights[i] / (count * double{vocabulary_->Idf(bow.words[i])}));
    }
  }
  slots_[slot] = PackedWords(bow);
  scales_[slot] = static_cast<float>(scale);
}

// `slots` is how many there were when the slot was taken.
void WeightedIndex::Name(std::uint32_t slot, std::uint32_t slots, WordId id, std::uint32_t shown) {
  const std::uint32_t count = Counted(shown);
  Word& word = words_.at(id);
  word.all.Add(slot, slots);
  if (count > 1) {
    word.twice.Add(slot, slots);
  }
  if (count > 2) {
    word.more.Add(slot, count);
  }
}

// Words are cut into ranges, each small enough for a core's cache, and what images say of a range
// is gathered first. Within a range images come in their order, so that each word gets the slots
// that it gets by one Add after the other.
std::vector<std::uint32_t> WeightedIndex::AddAll(const std::vector<const PackedBow*>& images) {
  constexpr std::size_t kRange = 2048;  // words
  constexpr std::size_t kPart = 64;     // images
  std::vector<std::uint32_t> slots;
  std::vector<std::uint32_t> counts;
  for (const PackedBow* image : images) {
    DEJA_VIEW_CHECK_OP(image->weights.size(), ==, image->words.size());
    DEJA_VIEW_CHECK(image->words.empty() || image->words.back() < words_.size());
    slots.push_back(TakeSlot());
    counts.push_back(slot_count());
  }
  const std::size_t ranges = (words_.size() + kRange - 1) / kRange;
  const std::size_t parts = (images.size() + kPart - 1) / kPart;
  std::vector<std::vector<Mention>> mentions(parts * ranges);
  ParallelFor(0, parts, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin * kPart; i < std::min(end * kPart, images.size()); ++i) {
      const PackedBow& bow = *images[i];
      Fill(slots[i], bow);
      for (std::size_t k = 0; k < bow.words.size(); ++k) {
        if (bow.weights[k] > 0) {
          mentions[i / kPart * ranges + bow.words[k] / kRange].push_back(
              {bow.words[k], static_cast<std::uint32_t>(i), bow.counts[k]});
        }
      }
    }
  });
  ParallelFor(0, ranges, [&](std::size_t begin, std::size_t end) {
    for (std::size_t range = begin; range < end; ++range) {
      for (std::size_t part = 0; part < parts; ++part) {
        for (const Mention& m : mentions[part * ranges + range]) {
          Name(slots[m.image], counts[m.image], m.word, m.count);
        }
      }
    }
  });
  return slots;
}

void WeightedIndex::Remove(std::uint32_t slot) {
  slots_.at(slot).ForEach([&](WordId word, float /*weight*/) {
    words_[word].all.Remove(slot);
    words_[word].twice.Remove(slot);
    words_[word].more.Remove(slot);
  });
  slots_[slot] = PackedWords();
  scales_[slot] = 0;
  free_slots_.push_back(slot);
}

void WeightedIndex::Clear() {
  *this = WeightedIndex(vocabulary_);
}

std::vector<float> WeightedIndex::Bounds(const WeightedBow& query) const {
  double total = 0;
  double largest = 0;
  for (const WeightedWord& w : query) {
    const double part = w.weight * double{vocabulary_->Idf(w.word)};
    total += part;
    largest = std::max(largest, part);
  }
  std::vector<float> bounds(slots_.size(), 0.0F);
  // The sum of a slot that shows all words kMaxCount times stays below 2^31.
  constexpr double kLargestTotal = double{std::numeric_limits<std::int32_t>::max()} / kMaxCount;
  const double unit = std::min(kLargestWeight / largest,
                               (kLargestTotal - static_cast<double>(query.size())) / total);
  if (!(total > 0) || !(unit > 0)) {
    return bounds;
  }
  SlotSums<std::uint32_t> sums(slot_count());
  for (std::size_t i = 0; i < query.size(); ++i) {
    Prefetch(query, i);
    const double part = query[i].weight * double{vocabulary_->Idf(query[i].word)};
    const auto weight = static_cast<std::uint32_t>(std::ceil(part * unit));
    const Word& word = words_.at(query[i].word);
    sums.Add(word.all, weight);
    sums.Add(word.twice, weight);
    for (std::uint32_t k = 0, size = word.more.size(); k < size; ++k) {
      sums[word.more.slot(k)] += weight * (word.more.count(k) - 2);
    }
  }
  sums.Finish();
  const auto factor = static_cast<float>(RoundingOf(query.size()) / unit);
  for (std::uint32_t slot = 0; slot < slot_count(); ++slot) {
    bounds[slot] =
        static_cast<float>(static_cast<std::int32_t>(sums[slot])) * factor * scales_[slot];
  }
  return bounds;
}

// What the words to come need is on its way from memory meanwhile.
void WeightedIndex::Prefetch(const WeightedBow& query, std::size_t i) const {
  constexpr std::size_t kAhead = 4;
  if (i + 2 * kAhead < query.size()) {
    __builtin_prefetch(&words_[query[i + 2 * kAhead].word]);
  }
  if (i + kAhead < query.size()) {
    const Word& word = words_[query[i + kAhead].word];
    word.all.Prefetch();
    word.twice.Prefetch();
    word.more.Prefetch();
  }
}

std::vector<float> WeightedIndex::Spread(const WeightedBow& query) const {
  std::vector<float> weights(words_.size(), 0.0F);
  for (const WeightedWord& w : query) {
    weights.at(w.word) = static_cast<float>(w.weight);
  }
  return weights;
}

float WeightedIndex::Dot(std::uint32_t slot, const std::vector<float>& query) const {
  float dot = 0;
  slots_[slot].ForEach([&](WordId word, float weight) { dot += query[word] * weight; });
  return dot;
}

std::size_t WeightedIndex::memory_bytes() const {
  std::size_t bytes = words_.capacity() * sizeof(Word) + slots_.capacity() * sizeof(PackedWords) +
                      scales_.capacity() * sizeof(float) +
                      free_slots_.capacity() * sizeof(std::uint32_t);
  for (const Word& word : words_) {
    bytes += word.all.memory_bytes() + word.twice.memory_bytes() + word.more.memory_bytes();
  }
  for (const PackedWords& slot : slots_) {
    bytes += slot.memory_bytes();
  }
  return bytes;
}

}  // namespace deja_view::internal
