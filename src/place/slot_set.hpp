#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace deja_view::internal {

/// Bitmaps come in blocks of 512 slots, which is a cache line.
constexpr std::uint32_t kBlockWords = 16;

/// The slots (entries) that show a word: a list when they are few, else a bitmap, which is both
/// smaller and faster to go through. 16 bytes, since there is one for each word.
class SlotSet {
 public:
  SlotSet() : capacity_(0), is_bitmap_(0) {}

  std::uint32_t size() const { return size_; }
  bool is_bitmap() const { return is_bitmap_; }

  const std::uint32_t* list() const { return data_.get(); }    ///< size() slots, in any order
  const std::uint32_t* bitmap() const { return data_.get(); }  ///< bitmap_words() x 32 slots
  std::uint32_t bitmap_words() const { return capacity_; }     ///< a multiple of kBlockWords

  /// The start of the list will be read soon; a bitmap waits for the others.
  void Prefetch() const {
    if (is_bitmap_) {
      return;
    }
    // An address, not a pointer: it may lie beyond the end, or start from none.
    const auto start = reinterpret_cast<std::uintptr_t>(data_.get());
    for (std::uintptr_t offset = 0; offset < 512; offset += 64) {
      __builtin_prefetch(
          reinterpret_cast<const void*>(start + offset));  // NOLINT(performance-no-int-to-ptr)
    }
  }

  /// Adds a slot that is not in the set; `slots` is how many there are in the database.
  void Add(std::uint32_t slot, std::uint32_t slots);

  /// Takes out a slot; does nothing where it is not in the set.
  void Remove(std::uint32_t slot);

  std::size_t memory_bytes() const { return capacity_ * sizeof(std::uint32_t); }

 private:
  void Reserve(std::uint32_t capacity);
  void TurnIntoBitmap(std::uint32_t slots);
  void SetBit(std::uint32_t slot);

  std::unique_ptr<std::uint32_t[]> data_;
  std::uint32_t size_ = 0;
  std::uint32_t capacity_ : 31;  // of data_, in elements
  std::uint32_t is_bitmap_ : 1;
};

/// The slots that show a word more than once, with their counts.
class RepeatList {
 public:
  std::uint32_t size() const { return size_; }
  std::uint32_t slot(std::uint32_t i) const { return data_[i] >> 8U; }
  std::uint32_t count(std::uint32_t i) const { return data_[i] & 255U; }  ///< 2 to 255

  /// The start of the list will be read soon.
  void Prefetch() const { __builtin_prefetch(data_.get()); }

  void Add(std::uint32_t slot, std::uint32_t count);
  /// Does nothing where the slot is not in the list.
  void Remove(std::uint32_t slot);

  std::size_t memory_bytes() const { return capacity_ * sizeof(std::uint32_t); }

 private:
  std::unique_ptr<std::uint32_t[]> data_;
  std::uint32_t size_ = 0;
  std::uint32_t capacity_ = 0;
};

/// Slots fit the 24 bits that RepeatList has for them.
constexpr std::uint32_t kMaxSlots = 1U << 24U;

}  // namespace deja_view::internal
