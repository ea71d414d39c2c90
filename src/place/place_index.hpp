#pragma once

#include "deja_view/place/place_match.hpp"
#include "deja_view/vocabulary/bow_vector.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "norms.hpp"
#include "similarity.hpp"

namespace deja_view::internal {

/// What a slot holds.
struct SlotEntry {
  int id = 0;
  int tag = 0;
  bool is_used = false;
  BowVector bow;
};

/// The inverted index, with the norms that one kind of score needs.
template <typename Norms>
class PlaceIndex {
 public:
  PlaceIndex(IdfMode mode, const Vocabulary& vocabulary);

  void Add(int id, int tag, const BowVector& bow);
  bool Remove(int id);
  bool Remove(int id, int tag);

  bool Contains(int id, int tag) const { return by_key_.count({id, tag}) > 0; }
  const WordWeights& weights() const { return weights_; }
  const WordSlots& word(WordId word) const { return words_[word]; }
  const std::vector<SlotEntry>& slots() const { return slots_; }
  std::uint64_t Norm(std::uint32_t slot) const { return norms_.Get(slot, weights_); }
  std::size_t size() const { return by_key_.size(); }
  std::size_t memory_bytes() const;

 private:
  using Key = std::pair<int, int>;  // id, tag

  std::uint32_t TakeSlot();
  void ChangeDf(const BowVector& bow, std::int64_t change);
  void RemoveSlot(std::uint32_t slot);

  WordWeights weights_;
  std::vector<WordSlots> words_;
  std::vector<SlotEntry> slots_;
  std::vector<std::uint32_t> free_slots_;
  std::map<Key, std::uint32_t> by_key_;
  Norms norms_;
};

extern template class PlaceIndex<L1Norms>;
extern template class PlaceIndex<SquaredNorms>;

/// The `query.max_results` best slots; the work of PlaceDatabase::Query.
std::vector<PlaceMatch> FindBest(const PlaceIndex<L1Norms>& index,
                                 const BowVector& bow,
                                 const PlaceQuery& query);
std::vector<PlaceMatch> FindBest(const PlaceIndex<SquaredNorms>& index,
                                 const BowVector& bow,
                                 const PlaceQuery& query);

}  // namespace deja_view::internal
