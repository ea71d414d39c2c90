// With Highway compiled once per instruction set, the best of which is picked at run time; without
// it, or vectors, plain loops. All give the same bits.
#include "kernels.hpp"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels.cpp"
#include "deja_view/base/instruction_sets-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace deja_view::internal::HWY_NAMESPACE {
namespace {

#if defined(DEJA_VIEW_HAVE_HIGHWAY) && HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;

// Four vectors of sums at a time: each is loaded and stored once for all bitmaps.
template <typename Sum>
void AddAll(const std::vector<WeightedBitmap<Sum>>& bitmaps, std::uint32_t words, Sum* sums) {
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

// Plain for all: what an instruction set has is the counting of a word's bits.
SynonymSums SumPairs(const std::vector<Descriptor>& centroids,
                     const std::vector<double>& values,
                     const std::vector<double>& weights) {
  SynonymSums s{values, std::vector<double>(values.size(), 1.0)};
  for (std::size_t i = 0; i < centroids.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      std::size_t distance = 0;
      for (std::size_t word = 0; word < 4; ++word) {
        distance += static_cast<std::size_t>(
            __builtin_popcountll(centroids[i].words[word] ^ centroids[j].words[word]));
      }
      if (distance < weights.size()) {
        const double k = weights[distance];
        s.sums[i] += k * values[j];
        s.sums[j] += k * values[i];
        s.totals[i] += k;
        s.totals[j] += k;
      }
    }
  }
  return s;
}

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
