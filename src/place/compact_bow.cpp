#include "compact_bow.hpp"

#include <algorithm>
#include <vector>

#include "similarity.hpp"

namespace deja_view::internal {
namespace {

void Put(std::uint64_t value, std::vector<std::uint8_t>* bytes) {
  while (value >= 128) {
    bytes->push_back(static_cast<std::uint8_t>(value | 128U));
    value >>= 7U;
  }
  bytes->push_back(static_cast<std::uint8_t>(value));
}

std::uint64_t Get(const std::uint8_t** bytes) {
  std::uint64_t value = 0;
  for (unsigned shift = 0;; shift += 7) {
    const std::uint64_t byte = *(*bytes)++;
    value |= (byte & 127U) << shift;
    if (byte < 128) {
      return value;
    }
  }
}

}  // namespace

CompactBow::CompactBow(const BowVector& bow) : descriptor_count_(bow.descriptor_count) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(bow.entries.size() * 2);
  std::uint64_t previous = 0;
  for (const WordCount& entry : bow.entries) {
    Put((entry.word - previous) << 1U | (entry.count > 1 ? 1U : 0U), &bytes);
    if (entry.count > 1) {
      bytes.push_back(static_cast<std::uint8_t>(std::min(entry.count, kMaxCount)));
    }
    previous = entry.word;
  }
  size_ = static_cast<std::uint32_t>(bytes.size());
  bytes_.reset(new std::uint8_t[bytes.size()]);
  std::copy(bytes.begin(), bytes.end(), bytes_.get());
}

BowVector CompactBow::Decode() const {
  BowVector bow;
  bow.descriptor_count = descriptor_count_;
  std::uint64_t word = 0;
  const std::uint8_t* byte = bytes_.get();
  const std::uint8_t* end = byte + size_;
  while (byte != end) {
    const std::uint64_t step = Get(&byte);
    word += step >> 1U;
    bow.entries.push_back({static_cast<WordId>(word), (step & 1U) != 0 ? *byte++ : 1U});
  }
  return bow;
}

}  // namespace deja_view::internal
