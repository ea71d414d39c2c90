#pragma once

#include "deja_view/vocabulary/bow_vector.hpp"

#include <cstdint>
#include <memory>

namespace deja_view::internal {

/// A bag of words in little more than a byte per word: differences of the sorted words in groups of
/// seven bits, the lowest bit of the number telling whether a count above 1 follows. Counts are cut
/// to kMaxCount.
class CompactBow {
 public:
  CompactBow() = default;
  explicit CompactBow(const BowVector& bow);

  BowVector Decode() const;
  std::size_t memory_bytes() const { return size_; }

 private:
  std::unique_ptr<std::uint8_t[]> bytes_;
  std::uint32_t size_ = 0;
  std::uint32_t descriptor_count_ = 0;
};

}  // namespace deja_view::internal
