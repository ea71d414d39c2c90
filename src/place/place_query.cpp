#include <algorithm>
#include <cmath>

#include "best_matches.hpp"
#include "kernels.hpp"
#include "place_index.hpp"

namespace deja_view::internal {
namespace {

bool IsWanted(const SlotEntry& entry, const PlaceQuery& query) {
  return entry.is_used && entry.id >= query.min_id && entry.id <= query.max_id;
}

// Calls f(entry, word) for the query's words; what a word's slots need is on its way from memory
// meanwhile.
template <typename Index, typename F>
void ForEachWord(const Index& index, const BowVector& bow, F f) {
  constexpr std::size_t kAhead = 4;
  const std::vector<WordCount>& entries = bow.entries;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (i + 2 * kAhead < entries.size()) {
      __builtin_prefetch(&index.word(entries[i + 2 * kAhead].word));
    }
    if (i + kAhead < entries.size()) {
      const WordSlots& word = index.word(entries[i + kAhead].word);
      word.all.Prefetch();
      word.repeats.Prefetch();
    }
    f(entries[i], index.word(entries[i].word));
  }
}

/// The sums of L1Parts for one query.
class L1Sums {
 public:
  L1Sums(const PlaceIndex<L1Norms>& index, const BowVector& bow)
      : index_(index),
        slots_(static_cast<std::uint32_t>(index.slots().size())),
        norm_(L1Norm(index.weights(), bow)),
        norms_(slots_),
        once_(slots_),
        more_(slots_),
        repeats_(slots_),
        rest_(slots_) {
    std::uint32_t longest = 0;
    for (std::uint32_t slot = 0; slot < slots_; ++slot) {
      norms_[slot] = static_cast<std::uint32_t>(index.Norm(slot));
      longest = std::max(longest, norms_[slot]);
    }
    has_long_ = longest > 2 * norm_;
    ForEachWord(
        index, bow, [this](const WordCount& entry, const WordSlots& word) { Add(entry, word); });
    once_.Finish();
    more_.Finish();
  }

  L1Parts Parts() const {
    return {norm_, norms_.data(), once_.data(), more_.data(), repeats_.data(), rest_.data()};
  }

 private:
  void Add(const WordCount& entry, const WordSlots& word) {
    const auto weight = static_cast<std::uint32_t>(index_.weights()[entry.word]);
    if (weight == 0) {
      return;
    }
    if (entry.count > 1) {
      more_.Add(word.all, weight);
      AddRest(word.repeats, weight, std::min(entry.count, kMaxCount), norm_);
      return;
    }
    once_.Add(word.all, weight);
    for (std::uint32_t i = 0, size = word.repeats.size(); i < size; ++i) {
      repeats_[word.repeats.slot(i)] += weight;
    }
    if (has_long_) {
      AddRest(word.repeats, weight, 1, 2 * norm_);
    }
  }

  // Adds w (min(a |b|, b |a|) - what the other parts hold of it): |a| where a > 1, else min(|b|, 2
  // |a|).
  void AddRest(const RepeatList& repeats,
               std::uint64_t weight,
               std::uint64_t count,
               std::uint64_t held) {
    for (std::uint32_t i = 0, size = repeats.size(); i < size; ++i) {
      const std::uint32_t slot = repeats.slot(i);
      const std::uint64_t b = norms_[slot];
      const std::uint64_t already = count > 1 ? held : std::min(b, held);
      rest_[slot] += weight * (std::min(count * b, repeats.count(i) * norm_) - already);
    }
  }

  const PlaceIndex<L1Norms>& index_;
  std::uint32_t slots_;
  std::uint64_t norm_;
  bool has_long_ = false;  // some slot's norm is above twice the query's
  SlotSums<std::uint32_t> norms_;
  SlotSums<std::uint32_t> once_;
  SlotSums<std::uint32_t> more_;
  SlotSums<std::uint32_t> repeats_;
  SlotSums<std::uint64_t> rest_;
};

void OfferSlot(const PlaceIndex<L1Norms>& index,
               const BowVector& bow,
               const L1Parts& parts,
               std::uint32_t slot,
               BestMatches* best) {
  const SlotEntry& entry = index.slots()[slot];
  const std::uint64_t norm = parts.norms[slot];
  std::uint64_t common = parts.Common(slot);
  if (!parts.IsExact(slot)) {
    if (L1Score(common, parts.norm, norm) < best->threshold()) {
      return;
    }
    common = L1Common(index.weights(), bow, parts.norm, entry.bow, norm);
  }
  best->Offer({entry.id, entry.tag, L1Score(common, parts.norm, norm)});
}

}  // namespace

std::vector<PlaceMatch> FindBest(const PlaceIndex<L1Norms>& index,
                                 const BowVector& bow,
                                 const PlaceQuery& query) {
  // Slots are filtered in blocks, each with the threshold that the blocks before have raised.
  constexpr std::uint32_t kBlock = 512;
  const L1Sums sums(index, bow);
  const L1Parts parts = sums.Parts();
  const auto slots = static_cast<std::uint32_t>(index.slots().size());
  BestMatches best(query);
  std::vector<std::uint32_t> found(kBlock);
  for (std::uint32_t begin = 0; begin < slots; begin += kBlock) {
    const std::uint32_t padded = (slots + kFilterBlock - 1) / kFilterBlock * kFilterBlock;
    const std::uint32_t end = std::min(begin + kBlock, padded);
    const std::uint32_t count = FilterL1(parts, best.threshold(), begin, end, found.data());
    const auto offer_all = [&](bool exact) {
      for (std::uint32_t i = 0; i < count; ++i) {
        const SlotEntry& entry = index.slots()[found[i]];
        if (IsWanted(entry, query) && parts.IsExact(found[i]) == exact) {
          OfferSlot(index, bow, parts, found[i], &best);
        }
      }
    };
    // The others take long; fewer of them are left under the threshold that these raise.
    offer_all(true);
    offer_all(false);
  }
  return best.Take();
}

std::vector<PlaceMatch> FindBest(const PlaceIndex<SquaredNorms>& index,
                                 const BowVector& bow,
                                 const PlaceQuery& query) {
  // Slack for thresholds that are compared before the last rounding of a score.
  constexpr double kSlack = 1 - 1e-9;
  const auto slots = static_cast<std::uint32_t>(index.slots().size());
  SlotSums<std::uint64_t> dots(slots);
  ForEachWord(index, bow, [&](const WordCount& entry, const WordSlots& word) {
    const auto weight = static_cast<std::uint64_t>(index.weights()[entry.word]);
    const std::uint64_t product = weight * weight * std::min(entry.count, kMaxCount);
    if (product == 0) {
      return;
    }
    dots.Add(word.all, product);
    for (std::uint32_t i = 0, size = word.repeats.size(); i < size; ++i) {
      dots[word.repeats.slot(i)] += product * (word.repeats.count(i) - 1);
    }
  });
  dots.Finish();

  BestMatches best(query);
  const std::uint64_t norm = SquaredNorm(index.weights(), bow);
  const auto norm_d = static_cast<double>(norm);
  for (std::uint32_t slot = 0; slot < slots; ++slot) {
    const std::uint64_t slot_norm = index.Norm(slot);
    const auto dot = static_cast<double>(dots[slot]);
    const double threshold = best.threshold() * kSlack;
    // Squares are compared: a root per slot would take longer than all the rest.
    if (dots[slot] == 0 ||
        dot * dot < threshold * threshold * norm_d * static_cast<double>(slot_norm)) {
      continue;
    }
    const SlotEntry& entry = index.slots()[slot];
    if (IsWanted(entry, query)) {
      best.Offer({entry.id, entry.tag, CosineScore(dots[slot], norm, slot_norm)});
    }
  }
  return best.Take();
}

}  // namespace deja_view::internal
