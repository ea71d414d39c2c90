// With Highway compiled once per instruction set, the best of which is picked at run time; without
// it, or vectors, plain loops. All give the same bits.
#include "kernels.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels.cpp"
#include "deja_view/base/instruction_sets-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace deja_view::internal::HWY_NAMESPACE {
namespace {

#if defined(DEJA_VIEW_HAVE_HIGHWAY) && HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;

// sums[slot] += weight for all slots of all bitmaps, bitmap after bitmap. Four vectors of sums at a
// time: each is loaded and stored once for all bitmaps.
template <typename Sum>
void AddEach(const std::vector<WeightedBitmap<Sum>>& bitmaps, std::uint32_t words, Sum* sums) {
  const hn::CappedTag<Sum, 16> d;
  const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
  for (std::uint32_t begin = 0; begin < 32 * words; begin += 4 * lanes) {
    Sum* here = sums + begin;
    auto s0 = hn::LoadU(d, here);
    auto s1 = hn::LoadU(d, here + lanes);
    auto s2 = hn::LoadU(d, here + 2 * lanes);
    auto s3 = hn::LoadU(d, here + 3 * lanes);
    for (const WeightedBitmap<Sum>& bitmap : bitmaps) {
      if (begin >= 32 * bitmap.words) {
        continue;
      }
      std::uint64_t bits = 0;
      std::memcpy(&bits, bitmap.bits + begin / 32, std::max(4U, lanes / 2));
      bits >>= begin % 32;
      const auto weight = hn::Set(d, bitmap.weight);
      const auto chosen = [&](std::uint32_t shift) HWY_ATTR {
        const std::uint64_t lane_bits = bits >> shift;
        std::uint8_t bytes[8];
        std::memcpy(bytes, &lane_bits, sizeof(bytes));
        return hn::IfThenElseZero(hn::LoadMaskBits(d, bytes), weight);
      };
      s0 = hn::Add(s0, chosen(0));
      s1 = hn::Add(s1, chosen(lanes));
      s2 = hn::Add(s2, chosen(2 * lanes));
      s3 = hn::Add(s3, chosen(3 * lanes));
    }
    hn::StoreU(s0, d, here);
    hn::StoreU(s1, d, here + lanes);
    hn::StoreU(s2, d, here + 2 * lanes);
    hn::StoreU(s3, d, here + 3 * lanes);
  }
}

// The bitmaps whose weight has a certain bit, a multiple of kAddedAtOnce, the last ones empty.
template <typename Sum>
using BitmapsOfBit = std::vector<WeightedBitmap<Sum>>;

constexpr std::size_t kAddedAtOnce = 8;

/// Sums of a block of slots as binary numbers that stand upright: bit b of all slots' sums is one
/// row of bits. A bitmap is then added to all slots of a row by a few logical operations (a
/// carry-save adder; Harley and Seal's way to count bits), whatever its weight.
template <typename Sum>
class UprightSums {
 public:
  static constexpr std::size_t kBits = 8 * sizeof(Sum);

  /// Bits above `used_bits` stay 0.
  explicit UprightSums(std::size_t used_bits) : used_bits_(used_bits) {}

  const std::uint32_t* row(std::size_t bit) const { return rows_[bit]; }
  void Clear() { std::memset(rows_, 0, sizeof(rows_)); }

  /// Adds 2^bit to the slots of each bitmap, whose words from `begin` on are the block's.
  HWY_INLINE void Add(const BitmapsOfBit<Sum>& bitmaps, std::size_t bit, std::uint32_t begin) {
    for (std::uint32_t at = 0; at < kBlockWords; at += Lanes()) {
      auto ones = hn::Load(kTag, rows_[bit] + at);
      auto twos = hn::Load(kTag, rows_[bit + 1] + at);
      auto fours = hn::Load(kTag, rows_[bit + 2] + at);
      for (std::size_t i = 0; i < bitmaps.size(); i += kAddedAtOnce) {
        const auto load = [&](std::size_t k) HWY_ATTR {
          const WeightedBitmap<Sum>& bitmap = bitmaps[i + k];
          return hn::LoadU(kTag, (begin < bitmap.words ? bitmap.bits + begin : kEmpty) + at);
        };
        auto twos_a = ones;
        auto twos_b = ones;
        auto fours_a = ones;
        auto fours_b = ones;
        auto eights = ones;
        AddBits(load(0), load(1), &ones, &twos_a);
        AddBits(load(2), load(3), &ones, &twos_b);
        AddBits(twos_a, twos_b, &twos, &fours_a);
        AddBits(load(4), load(5), &ones, &twos_a);
        AddBits(load(6), load(7), &ones, &twos_b);
        AddBits(twos_a, twos_b, &twos, &fours_b);
        AddBits(fours_a, fours_b, &fours, &eights);
        for (std::size_t row = bit + 3; row < used_bits_; ++row) {
          const auto sum = hn::Load(kTag, rows_[row] + at);
          hn::Store(hn::Xor(sum, eights), kTag, rows_[row] + at);
          eights = hn::And(sum, eights);
        }
      }
      hn::Store(ones, kTag, rows_[bit] + at);
      hn::Store(twos, kTag, rows_[bit + 1] + at);
      hn::Store(fours, kTag, rows_[bit + 2] + at);
    }
  }

 private:
  using Tag = hn::CappedTag<std::uint32_t, kBlockWords>;
  using Bits = hn::Vec<Tag>;
  static constexpr Tag kTag{};
  alignas(64) static constexpr std::uint32_t kEmpty[kBlockWords] = {};

  static HWY_INLINE std::uint32_t Lanes() { return static_cast<std::uint32_t>(hn::Lanes(kTag)); }

  // sum + a + b of each bit; what is carried goes to `carry`.
  static HWY_INLINE void AddBits(Bits a, Bits b, Bits* sum, Bits* carry) {
    const auto differ = hn::Xor(a, b);
    *carry = hn::Or(hn::And(a, b), hn::And(differ, *sum));
    *sum = hn::Xor(differ, *sum);
  }

  std::size_t used_bits_;
  alignas(64) std::uint32_t rows_[kBits + 3][kBlockWords] = {};  // what is beyond is cut off
};

template <typename Sum>
std::size_t BitsOfTotal(const std::vector<WeightedBitmap<Sum>>& bitmaps) {
  double total = 0;
  for (const WeightedBitmap<Sum>& bitmap : bitmaps) {
    total += static_cast<double>(bitmap.weight);
  }
  const int bits = total > 0 ? std::ilogb(total) + 2 : 1;  // one more, since it is rounded
  return std::min<std::size_t>(8 * sizeof(Sum), static_cast<std::size_t>(bits));
}

template <typename Sum>
std::vector<BitmapsOfBit<Sum>> SortByBit(const std::vector<WeightedBitmap<Sum>>& bitmaps) {
  std::vector<BitmapsOfBit<Sum>> of_bit(8 * sizeof(Sum));
  for (const WeightedBitmap<Sum>& bitmap : bitmaps) {
    for (std::size_t bit = 0; bit < of_bit.size(); ++bit) {
      if ((bitmap.weight >> bit & 1U) != 0) {
        of_bit[bit].push_back(bitmap);
      }
    }
  }
  for (BitmapsOfBit<Sum>& its : of_bit) {
    while (its.size() % kAddedAtOnce != 0) {
      its.push_back({nullptr, 0, 0});
    }
  }
  return of_bit;
}

// Hundreds of bitmaps are more than what the processor sees coming by itself.
template <typename Sum>
void Prefetch(const std::vector<WeightedBitmap<Sum>>& bitmaps, std::uint32_t begin) {
  for (const WeightedBitmap<Sum>& bitmap : bitmaps) {
    if (begin < bitmap.words) {
      constexpr int kRead = 0;
      constexpr int kSecondLevel = 2;  // the first one is full of the block before
      __builtin_prefetch(bitmap.bits + begin, kRead, kSecondLevel);
    }
  }
}

template <typename Sum>
void AddAll(const std::vector<WeightedBitmap<Sum>>& bitmaps, std::uint32_t words, Sum* sums) {
  constexpr std::size_t kFew = 32;  // for which it is not worth while
  if (bitmaps.size() < kFew) {
    AddEach(bitmaps, words, sums);
    return;
  }
  const std::vector<BitmapsOfBit<Sum>> of_bit = SortByBit(bitmaps);
  UprightSums<Sum> upright(BitsOfTotal(bitmaps));
  std::vector<WeightedBitmap<Sum>> rows;
  for (std::size_t bit = 0; bit < BitsOfTotal(bitmaps); ++bit) {
    rows.push_back({upright.row(bit), kBlockWords, Sum{1} << bit});
  }
  for (std::uint32_t begin = 0; begin < words; begin += kBlockWords) {
    Prefetch(bitmaps, begin + kBlockWords);
    upright.Clear();
    for (std::size_t bit = 0; bit < of_bit.size(); ++bit) {
      upright.Add(of_bit[bit], bit, begin);
    }
    AddEach(rows, kBlockWords, sums + std::size_t{32} * begin);
  }
}

std::uint32_t Filter(const L1Parts& parts,
                     double threshold,
                     std::uint32_t begin,
                     std::uint32_t end,
                     std::uint32_t* found) {
  const hn::CappedTag<double, kFilterBlock> d;
  const hn::Rebind<std::int32_t, decltype(d)> d32;
  const hn::Rebind<std::int64_t, decltype(d)> d64;
  const auto load = [&](const std::uint32_t* from) HWY_ATTR {
    return hn::PromoteTo(d, hn::LoadU(d32, reinterpret_cast<const std::int32_t*>(from)));
  };
  const auto norm = hn::Set(d, static_cast<double>(parts.norm));
  const auto norm_twice = hn::Add(norm, norm);
  const auto factor = hn::Set(d, threshold * kFilterSlack * static_cast<double>(parts.norm));
  const auto half = hn::Set(d, 0.5);
  const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
  std::uint32_t count = 0;
  for (std::uint32_t slot = begin; slot < end; slot += lanes) {
    const auto b = load(parts.norms + slot);
    const auto least = hn::Min(b, norm);
    const auto twice = hn::Sub(hn::Min(b, norm_twice), least);
    const auto* rest = reinterpret_cast<const std::int64_t*>(parts.rest + slot);
    auto common = hn::ConvertTo(d, hn::LoadU(d64, rest));
    common = hn::Add(common, hn::Mul(load(parts.once + slot), least));
    common = hn::Add(common, hn::Mul(load(parts.more + slot), norm));
    common = hn::Add(common, hn::Mul(load(parts.repeats + slot), twice));
    const auto passes = hn::And(hn::Ge(common, hn::Mul(factor, b)), hn::Ge(common, half));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, passes, bits);
    for (std::uint32_t left = bits[0]; left != 0; left &= left - 1) {
      found[count++] = slot + static_cast<std::uint32_t>(__builtin_ctz(left));
    }
  }
  return count;
}

#else

template <typename Sum>
void AddAll(const std::vector<WeightedBitmap<Sum>>& bitmaps, std::uint32_t /*words*/, Sum* sums) {
  for (const WeightedBitmap<Sum>& bitmap : bitmaps) {
    Sum* here = sums;
    for (std::uint32_t word = 0; word < bitmap.words; ++word, here += 32) {
      for (std::uint32_t bits = bitmap.bits[word]; bits != 0; bits &= bits - 1) {
        here[__builtin_ctz(bits)] += bitmap.weight;
      }
    }
  }
}

std::uint32_t Filter(const L1Parts& parts,
                     double threshold,
                     std::uint32_t begin,
                     std::uint32_t end,
                     std::uint32_t* found) {
  const double factor = threshold * kFilterSlack * static_cast<double>(parts.norm);
  std::uint32_t count = 0;
  for (std::uint32_t slot = begin; slot < end; ++slot) {
    const std::uint64_t common = parts.Common(slot);
    const bool passes = common != 0 && static_cast<double>(common) >=
                                           factor * static_cast<double>(parts.norms[slot]);
    found[count] = slot;
    count += passes ? 1 : 0;
  }
  return count;
}

#endif

template <typename Sum>
void AddAll(const std::vector<WeightedBitmap<Sum>>& bitmaps, Sum* sums) {
  std::uint32_t words = 0;
  for (const WeightedBitmap<Sum>& bitmap : bitmaps) {
    words = std::max(words, bitmap.words);
  }
  AddAll(bitmaps, words, sums);
}

void Add32(const std::vector<WeightedBitmap<std::uint32_t>>& bitmaps, std::uint32_t* sums) {
  AddAll(bitmaps, sums);
}

void Add64(const std::vector<WeightedBitmap<std::uint64_t>>& bitmaps, std::uint64_t* sums) {
  AddAll(bitmaps, sums);
}

// A pair of synonyms, to the sums of both.
void AddPair(
    std::size_t i, std::size_t j, double k, const std::vector<double>& values, SynonymSums* s) {
  s->sums[i] += k * values[j];
  s->sums[j] += k * values[i];
  s->totals[i] += k;
  s->totals[j] += k;
}

#if defined(DEJA_VIEW_HAVE_HIGHWAY) && HWY_TARGET != HWY_SCALAR

// Each centroid against several of those before it at a time; hardly any are synonyms.
SynonymSums SumPairs(const std::vector<Descriptor>& centroids,
                     const std::vector<double>& values,
                     const std::vector<double>& weights) {
  const hn::ScalableTag<std::int64_t> d;
  const hn::Repartition<std::uint8_t, decltype(d)> d8;
  const std::size_t lanes = hn::Lanes(d);
  const std::size_t padded = centroids.size() + lanes;
  std::vector<std::int64_t> planes(4 * padded);  // word after word of all
  for (std::size_t i = 0; i < centroids.size(); ++i) {
    for (std::size_t word = 0; word < 4; ++word) {
      planes[word * padded + i] = static_cast<std::int64_t>(centroids[i].words[word]);
    }
  }
  const auto limit = hn::Set(d, static_cast<std::int64_t>(weights.size()));
  std::vector<std::int64_t> distances(lanes);
  SynonymSums s{values, std::vector<double>(values.size(), 1.0)};
  for (std::size_t i = 1; i < centroids.size(); ++i) {
    const std::int64_t* own = planes.data() + i;
    for (std::size_t begin = 0; begin < i; begin += lanes) {
      const std::int64_t* others = planes.data() + begin;
      const auto bits = [&](std::size_t word) HWY_ATTR {
        return hn::PopulationCount(hn::BitCast(
            d8, hn::Xor(hn::Set(d, own[word * padded]), hn::LoadU(d, others + word * padded))));
      };
      // At most 8 per byte and word, 32 in all.
      const auto bytes = hn::Add(hn::Add(bits(0), bits(1)), hn::Add(bits(2), bits(3)));
      const auto distance = hn::BitCast(d, hn::SumsOf8(bytes));
      if (hn::AllFalse(d, hn::Lt(distance, limit))) {
        continue;
      }
      hn::StoreU(distance, d, distances.data());
      for (std::size_t j = begin; j < std::min(i, begin + lanes); ++j) {
        const auto bit_count = static_cast<std::size_t>(distances[j - begin]);
        if (bit_count < weights.size()) {
          AddPair(i, j, weights[bit_count], values, &s);
        }
      }
    }
  }
  return s;
}

#else

SynonymSums SumPairs(const std::vector<Descriptor>& centroids,
                     const std::vector<double>& values,
                     const std::vector<double>& weights) {
  SynonymSums s{values, std::vector<double>(values.size(), 1.0)};
  for (std::size_t i = 0; i < centroids.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const auto distance = static_cast<std::size_t>(HammingDistance(centroids[i], centroids[j]));
      if (distance < weights.size()) {
        AddPair(i, j, weights[distance], values, &s);
      }
    }
  }
  return s;
}

#endif

}  // namespace
}  // namespace deja_view::internal::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace deja_view::internal {

HWY_EXPORT(Add32);
HWY_EXPORT(Add64);
HWY_EXPORT(Filter);
HWY_EXPORT(SumPairs);

void AddBitmaps(const std::vector<WeightedBitmap<std::uint32_t>>& bitmaps, std::uint32_t* sums) {
  HWY_DYNAMIC_DISPATCH(Add32)(bitmaps, sums);
}

void AddBitmaps(const std::vector<WeightedBitmap<std::uint64_t>>& bitmaps, std::uint64_t* sums) {
  HWY_DYNAMIC_DISPATCH(Add64)(bitmaps, sums);
}

std::uint32_t FilterL1(const L1Parts& parts,
                       double threshold,
                       std::uint32_t begin,
                       std::uint32_t end,
                       std::uint32_t* found) {
  return HWY_DYNAMIC_DISPATCH(Filter)(parts, threshold, begin, end, found);
}

SynonymSums SumSynonyms(const std::vector<Descriptor>& centroids,
                        const std::vector<double>& values,
                        const std::vector<double>& weights) {
  return HWY_DYNAMIC_DISPATCH(SumPairs)(centroids, values, weights);
}

}  // namespace deja_view::internal
#endif
