#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels.hpp"
#include "slot_set.hpp"

namespace deja_view::internal {

/// Sums of weights per slot.
template <typename Sum>
class SlotSums {
 public:
  explicit SlotSums(std::uint32_t slots) : sums_(Padded(slots), 0) {}

  /// Room for whole blocks of a bitmap.
  static std::size_t Padded(std::uint32_t slots) {
    return (slots / (32 * kBlockWords) + 1) * std::size_t{32} * kBlockWords;
  }

  Sum operator[](std::uint32_t slot) const { return sums_[slot]; }
  Sum& operator[](std::uint32_t slot) { return sums_[slot]; }
  Sum* data() { return sums_.data(); }
  const Sum* data() const { return sums_.data(); }
  void Resize(std::uint32_t slots) { sums_.resize(Padded(slots), 0); }
  std::size_t memory_bytes() const { return sums_.capacity() * sizeof(Sum); }

  /// Adds `weight`, which may be a negative number modulo 2^n, to the sum of every slot of `set`. A
  /// list is added at once; a bitmap waits for Finish, which goes through all of them together, so
  /// that each sum is loaded and stored once. `set` must stay as it is until then.
  void Add(const SlotSet& set, Sum weight) {
    if (set.is_bitmap()) {
      // A bitmap may reach beyond the last slot.
      const auto words = static_cast<std::uint32_t>(sums_.size() / 32);
      bitmaps_.push_back({set.bitmap(), std::min(set.bitmap_words(), words), weight});
      return;
    }
    const std::uint32_t* list = set.list();
    Sum* sums = sums_.data();
    const std::uint32_t size = set.size();
    std::uint32_t i = 0;
    for (; i + 4 <= size; i += 4) {  // unrolled: the loop itself would take a quarter of the time
      sums[list[i]] += weight;
      sums[list[i + 1]] += weight;
      sums[list[i + 2]] += weight;
      sums[list[i + 3]] += weight;
    }
    for (; i < size; ++i) {
      sums[list[i]] += weight;
    }
  }

  void Finish() {
    AddBitmaps(bitmaps_, sums_.data());
    bitmaps_.clear();
  }

 private:
  std::vector<Sum> sums_;
  std::vector<WeightedBitmap<Sum>> bitmaps_;
};

}  // namespace deja_view::internal
