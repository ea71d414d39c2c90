#include <algorithm>
#include <cmath>

#include "best_matches.hpp"
#include "place_index.hpp"

namespace deja_view::internal {
namespace {

// Slack for thresholds that are compared before the last rounding of a score.
constexpr double kRounding = 1 - 1e-9;

bool IsWanted(const SlotEntry& entry, const PlaceQuery& query) {
  return entry.is_used && entry.id >= query.min_id && entry.id <= query.max_id;
}

/// Sums over the words that the query and a slot share, of w min(a |b|, b |a|) in parts.
///
/// a and b are nearly always 1, and |a| and |b| nearly equal, so nearly every word adds w min(|a|,
/// |b|). To add only a constant per slot and word, the sums are kept in parts, with |a| and |b|
/// multiplied at the end:
///   once     sum of w, words with a = 1                         x min(|a|, |b|)
///   more     sum of w, words with a > 1                         x |a|, if 2 |b| >= |a|
///   repeats  sum of w, words with a = 1, b > 1                  x min(|b|, 2 |a|) - min(|b|, |a|)
///   rest     what these leave out of the words with a > 1 and b > 1, and, for |b| > 2 |a|, of
///   those with
///            a = 1, b > 2; |a| and |b| already multiplied
/// For 2 |b| < |a| this is an upper bound; such a slot is scored from scratch when the bound lets
/// it.
class L1Sums {
 public:
  L1Sums(const PlaceIndex<L1Norms>& index, const BowVector& bow)
      : index_(index), norm_(L1Norm(index.weights(), bow)) {
    const auto slots = static_cast<std::uint32_t>(index.slots().size());
    const std::uint32_t padded = Accumulator<std::uint32_t>::PaddedSlots(slots);
    norms_.resize(padded);
    for (std::uint32_t slot = 0; slot < slots; ++slot) {
      norms_[slot] = static_cast<std::uint32_t>(index.Norm(slot));
    }
    has_long_ = slots > 0 && *std::max_element(norms_.begin(), norms_.end()) > 2 * norm_;
    once_.resize(padded);
    more_.resize(padded);
    repeats_.resize(padded);
    rest_.resize(padded);
    Accumulator<std::uint32_t> accumulator(index.kernel(), slots);
    for (const WordCount& entry : bow.entries) {
      Add(entry, &accumulator);
    }
    accumulator.Finish();
  }

  std::uint64_t norm() const { return norm_; }
  std::uint64_t norm(std::uint32_t slot) const { return norms_[slot]; }

  bool IsExact(std::uint32_t slot) const { return 2 * norm(slot) >= norm_; }

  std::uint64_t Common(std::uint32_t slot) const {
    const std::uint64_t b = norms_[slot];
    const std::uint64_t least = std::min(norm_, b);
    return once_[slot] * least + more_[slot] * norm_ +
           repeats_[slot] * (std::min(b, 2 * norm_) - least) + rest_[slot];
  }

 private:
  void Add(const WordCount& entry, Accumulator<std::uint32_t>* accumulator) {
    const auto weight = static_cast<std::uint32_t>(index_.weights()[entry.word]);
    const WordSlots& word = index_.word(entry.word);
    if (weight == 0) {
      return;
    }
    if (entry.count > 1) {
      accumulator->Add(word.all, weight, more_.data());
      AddRest(word.repeats, weight, std::min(entry.count, kMaxCount), norm_);
      return;
    }
    accumulator->Add(word.all, weight, once_.data());
    for (std::uint32_t i = 0, size = word.repeats.size(); i < size; ++i) {
      repeats_[word.repeats.slot(i)] += weight;
    }
    if (has_long_) {
      AddRest(word.repeats, weight, 1, 2 * norm_);
    }
  }

  // Adds w (min(a |b|, b |a|) - min(|b|, counted)) where `counted` is below |b|, or a > 1.
  void AddRest(const RepeatList& repeats,
               std::uint64_t weight,
               std::uint64_t count,
               std::uint64_t counted) {
    for (std::uint32_t i = 0, size = repeats.size(); i < size; ++i) {
      const std::uint32_t slot = repeats.slot(i);
      const std::uint64_t b = norms_[slot];
      const std::uint64_t already = count > 1 ? counted : std::min(b, counted);
      rest_[slot] += weight * (std::min(count * b, repeats.count(i) * norm_) - already);
    }
  }

  const PlaceIndex<L1Norms>& index_;
  std::uint64_t norm_;
  bool has_long_ = false;  // some slot's norm is above twice the query's
  std::vector<std::uint32_t> norms_;
  std::vector<std::uint32_t> once_;
  std::vector<std::uint32_t> more_;
  std::vector<std::uint32_t> repeats_;
  std::vector<std::uint64_t> rest_;  // modulo 2^64
};

}  // namespace

std::vector<PlaceMatch> FindBest(const PlaceIndex<L1Norms>& index,
                                 const BowVector& bow,
                                 const PlaceQuery& query) {
  const L1Sums sums(index, bow);
  BestMatches best(query);
  const auto norm = static_cast<double>(sums.norm());
  for (std::uint32_t slot = 0; slot < index.slots().size(); ++slot) {
    const std::uint64_t bound = sums.Common(slot);
    const double scale = norm * static_cast<double>(sums.norm(slot));
    if (static_cast<double>(bound) < best.threshold() * kRounding * scale || bound == 0) {
      continue;
    }
    const SlotEntry& entry = index.slots()[slot];
    if (!IsWanted(entry, query)) {
      continue;
    }
    const std::uint64_t common =
        sums.IsExact(slot)
            ? bound
            : L1Common(index.weights(), bow, sums.norm(), entry.bow.Decode(), sums.norm(slot));
    best.Offer({entry.id, entry.tag, L1Score(common, sums.norm(), sums.norm(slot))});
  }
  return best.Take();
}

std::vector<PlaceMatch> FindBest(const PlaceIndex<SquaredNorms>& index,
                                 const BowVector& bow,
                                 const PlaceQuery& query) {
  const auto slots = static_cast<std::uint32_t>(index.slots().size());
  std::vector<std::uint64_t> dots(Accumulator<std::uint64_t>::PaddedSlots(slots));
  Accumulator<std::uint64_t> accumulator(index.kernel(), slots);
  for (const WordCount& entry : bow.entries) {
    const auto weight = static_cast<std::uint64_t>(index.weights()[entry.word]);
    const std::uint64_t product = weight * weight * std::min(entry.count, kMaxCount);
    const WordSlots& word = index.word(entry.word);
    if (product == 0) {
      continue;
    }
    accumulator.Add(word.all, product, dots.data());
    for (std::uint32_t i = 0, size = word.repeats.size(); i < size; ++i) {
      dots[word.repeats.slot(i)] += product * (word.repeats.count(i) - 1);
    }
  }
  accumulator.Finish();

  BestMatches best(query);
  const std::uint64_t norm = SquaredNorm(index.weights(), bow);
  const auto norm_d = static_cast<double>(norm);
  for (std::uint32_t slot = 0; slot < slots; ++slot) {
    const std::uint64_t slot_norm = index.Norm(slot);
    const auto dot = static_cast<double>(dots[slot]);
    const double threshold = best.threshold() * kRounding;
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
