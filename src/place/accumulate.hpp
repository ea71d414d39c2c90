#pragma once

#include <cstdint>
#include <vector>

#include "slot_set.hpp"

namespace deja_view::internal {

/// sums[slot] += weight for every slot of a bitmap of `words` x 32 slots.
using AddBitmapFunction = void (*)(const std::uint32_t* bitmap,
                                   std::uint32_t words,
                                   std::uint32_t weight,
                                   std::uint32_t* sums);
using AddBitmap64Function = void (*)(const std::uint32_t* bitmap,
                                     std::uint32_t words,
                                     std::uint64_t weight,
                                     std::uint64_t* sums);

/// One implementation; all give the same sums.
struct AccumulateKernel {
  const char* name;
  AddBitmapFunction add_bitmap;
  AddBitmap64Function add_bitmap_64;
};

/// The implementations that this processor can run, the fastest first.
std::vector<AccumulateKernel> AvailableAccumulateKernels();

/// Adds weights to the sums of all slots that sets hold. Lists are added at once, bitmaps are kept
/// until Finish, which goes through them together, a part of the slots at a time, so that sums stay
/// in the nearest cache.
template <typename Sum>
class Accumulator {
 public:
  Accumulator(const AccumulateKernel& kernel, std::uint32_t slots)
      : kernel_(kernel), slots_(slots) {}

  /// `sums` has room for PaddedSlots(slots) and outlives Finish. Unsigned: adding a negative number
  /// wraps around, as it should.
  void Add(const SlotSet& set, Sum weight, Sum* sums) {
    if (set.is_bitmap()) {
      bitmaps_.push_back({set.bitmap(), set.bitmap_words(), weight, sums});
      return;
    }
    const std::uint32_t* list = set.list();
    for (std::uint32_t i = 0, size = set.size(); i < size; ++i) {
      sums[list[i]] += weight;
    }
  }

  void Finish();

  /// Bitmaps are padded to whole words.
  static std::uint32_t PaddedSlots(std::uint32_t slots) { return (slots + 63) / 64 * 64; }

 private:
  struct Bitmap {
    const std::uint32_t* bits;
    std::uint32_t words;
    Sum weight;
    Sum* sums;
  };

  AccumulateKernel kernel_;
  std::uint32_t slots_;
  std::vector<Bitmap> bitmaps_;
};

extern template class Accumulator<std::uint32_t>;
extern template class Accumulator<std::uint64_t>;

}  // namespace deja_view::internal
