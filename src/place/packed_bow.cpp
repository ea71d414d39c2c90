#include "deja_view/place/packed_bow.hpp"

#include "deja_view/base/check.hpp"

#include <limits>

namespace deja_view {

PackedBow Pack(const BowVector& bow, const WeightedBow& weighted) {
  DEJA_VIEW_CHECK(weighted.empty() || weighted.size() == bow.entries.size());
  PackedBow packed;
  packed.descriptor_count = bow.descriptor_count;
  packed.words.reserve(bow.entries.size());
  packed.counts.reserve(bow.entries.size());
  for (const WordCount& entry : bow.entries) {
    DEJA_VIEW_CHECK_OP(entry.count, <=, std::numeric_limits<std::uint16_t>::max());
    packed.words.push_back(entry.word);
    packed.counts.push_back(static_cast<std::uint16_t>(entry.count));
  }
  packed.weights.reserve(weighted.size());
  for (const WeightedWord& word : weighted) {
    packed.weights.push_back(static_cast<float>(word.weight));
  }
  return packed;
}

BowVector CountsOf(const PackedBow& packed) {
  BowVector bow;
  bow.descriptor_count = packed.descriptor_count;
  bow.entries.reserve(packed.words.size());
  for (std::size_t i = 0; i < packed.words.size(); ++i) {
    bow.entries.push_back({packed.words[i], packed.counts[i]});
  }
  return bow;
}

}  // namespace deja_view
