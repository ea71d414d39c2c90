#include "slot_set.hpp"

#include <algorithm>

namespace deja_view::internal {
namespace {

// A set becomes a bitmap when it holds more than one slot in this many; measured, going through the
// list takes longer from there on. It stays one, for a bitmap ends with its last slot and so costs
// no more when the database grows.
constexpr std::uint32_t kBitmapRatio = 40;
constexpr std::uint32_t kSmallestBitmap = 64;  // slots; before, a list does as well

// A quarter more, which wastes an eighth on average.
std::uint32_t Grown(std::uint32_t capacity) {
  return std::max<std::uint32_t>(2, capacity + (capacity + 3) / 4);
}

void Move(std::unique_ptr<std::uint32_t[]>* data, std::uint32_t size, std::uint32_t capacity) {
  std::unique_ptr<std::uint32_t[]> larger(new std::uint32_t[capacity]());
  std::copy_n(data->get(), size, larger.get());
  *data = std::move(larger);
}

}  // namespace

void SlotSet::Reserve(std::uint32_t capacity) {
  if (capacity > capacity_) {
    std::uint32_t larger = std::max(capacity, Grown(capacity_));
    if (is_bitmap_) {
      larger = (larger + kBlockWords - 1) / kBlockWords * kBlockWords;
    }
    Move(&data_, is_bitmap_ ? capacity_ : size_, larger);
    capacity_ = larger & 0x7fffffffU;
  }
}

void SlotSet::SetBit(std::uint32_t slot) {
  Reserve(slot / 32 + 1);
  data_[slot / 32] |= 1U << (slot % 32);
}

void SlotSet::TurnIntoBitmap(std::uint32_t slots) {
  const std::unique_ptr<std::uint32_t[]> list = std::move(data_);
  is_bitmap_ = 1;
  capacity_ = 0;
  Reserve((slots + 31) / 32);
  for (std::uint32_t i = 0; i < size_; ++i) {
    SetBit(list[i]);
  }
}

void SlotSet::Add(std::uint32_t slot, std::uint32_t slots) {
  if (!is_bitmap_ && size_ >= kSmallestBitmap && size_ * kBitmapRatio > slots) {
    TurnIntoBitmap(slots);
  }
  if (is_bitmap_) {
    SetBit(slot);
  } else {
    Reserve(size_ + 1);
    data_[size_] = slot;
  }
  ++size_;
}

void SlotSet::Remove(std::uint32_t slot) {
  if (is_bitmap_) {
    const std::uint32_t bit = 1U << (slot % 32);
    if (slot / 32 < capacity_ && (data_[slot / 32] & bit) != 0) {
      data_[slot / 32] &= ~bit;
      --size_;
    }
    return;
  }
  std::uint32_t* const end = data_.get() + size_;
  std::uint32_t* const found = std::find(data_.get(), end, slot);
  if (found != end) {
    *found = data_[--size_];
  }
}

void RepeatList::Add(std::uint32_t slot, std::uint32_t count) {
  if (size_ == capacity_) {
    capacity_ = Grown(capacity_);
    Move(&data_, size_, capacity_);
  }
  data_[size_++] = slot << 8U | count;
}

void RepeatList::Remove(std::uint32_t slot) {
  std::uint32_t* const end = data_.get() + size_;
  std::uint32_t* const found =
      std::find_if(data_.get(), end, [slot](std::uint32_t entry) { return entry >> 8U == slot; });
  if (found != end) {
    *found = data_[--size_];
  }
}

}  // namespace deja_view::internal
