// Compiled once per instruction set; Highway picks the best at run time.
#include <algorithm>
#include <cstdint>

#include "descend.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "descend_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace deja_view::internal::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

inline std::int64_t Distance(const Descriptor& a, const Descriptor& b) {
  return __builtin_popcountll(a.words[0] ^ b.words[0]) +
         __builtin_popcountll(a.words[1] ^ b.words[1]) +
         __builtin_popcountll(a.words[2] ^ b.words[2]) +
         __builtin_popcountll(a.words[3] ^ b.words[3]);
}

// In a key the distance is above, the index below: the least key is the nearest child, of equally
// near ones the first.
#if HWY_TARGET <= HWY_AVX3_DL

using Words = hn::FixedTag<std::uint64_t, 8>;
using WordVector = hn::Vec<Words>;

// Bits that differ, per 64-bit word, of two children, of which the first `present` words are read.
inline WordVector PairCounts(WordVector twice, const Descriptor* children, std::size_t present) {
  const Words d;
  const auto mask = hn::FirstN(d, present);
  const auto words = hn::MaskedLoad(mask, d, children->words.data());
  return hn::PopulationCount(hn::Xor(twice, words));
}

// Distances of four children in the order [0 2 0 2 1 3 1 3].
inline WordVector QuartetDistances(WordVector p0, WordVector p1) {
  const Words d;
  const auto sums = hn::Add(hn::InterleaveLower(d, p0, p1), hn::InterleaveUpper(d, p0, p1));
  return hn::Add(sums, hn::SwapAdjacentBlocks(sums));
}

// Keys of children [base, base + 8), all ones where there is none.
inline WordVector OctetKeys(WordVector twice,
                            const Descriptor* children,
                            std::uint32_t base,
                            std::uint32_t count) {
  const Words d;
  const std::uint32_t here = std::min(count - base, 8U);
  const auto pair = [&](std::uint32_t first) {
    const std::uint32_t present = here > first ? std::min(here - first, 2U) : 0U;
    // Of an absent pair no word is read.
    return PairCounts(twice, children + base + std::min(first, here), present * 4);
  };
  const auto distances =
      hn::OddEvenBlocks(QuartetDistances(pair(4), pair(6)), QuartetDistances(pair(0), pair(2)));
  alignas(64) static constexpr std::uint64_t kOrder[8] = {0, 2, 4, 6, 1, 3, 5, 7};
  const auto order = hn::Load(d, kOrder);
  const auto keys = hn::Or(hn::ShiftLeft<32>(distances), hn::Add(order, hn::Set(d, base)));
  const auto none = hn::Set(d, ~std::uint64_t{0});
  return hn::IfThenElse(hn::Lt(order, hn::Set(d, here)), keys, none);
}

inline std::uint32_t NearestChild(const Descriptor& descriptor,
                                  const Descriptor* children,
                                  std::uint32_t count) {
  const Words d;
  const hn::FixedTag<std::uint64_t, 4> half;
  const auto once = hn::LoadU(half, descriptor.words.data());
  const auto twice = hn::Combine(d, once, once);
  auto best = OctetKeys(twice, children, 0, count);
  for (std::uint32_t base = 8; base < count; base += 8) {
    best = hn::Min(best, OctetKeys(twice, children, base, count));
  }
  return static_cast<std::uint32_t>(hn::GetLane(hn::MinOfLanes(d, best)));
}

#else

// The bit counts of 64-bit words are the fastest that these have.
inline std::uint32_t NearestChild(const Descriptor& descriptor,
                                  const Descriptor* children,
                                  std::uint32_t count) {
  std::uint64_t best = ~std::uint64_t{0};
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto distance = static_cast<std::uint64_t>(Distance(descriptor, children[i]));
    best = std::min(best, distance << 32U | i);
  }
  return static_cast<std::uint32_t>(best);
}

#endif

#include "descend.inc"

}  // namespace

DescendKernel MakeDescendKernel() {
  return MakeKernel();
}

}  // namespace deja_view::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace deja_view::internal {

HWY_EXPORT(MakeDescendKernel);

DescendKernel ChooseDescendKernel() {
  return HWY_DYNAMIC_DISPATCH(MakeDescendKernel)();
}

}  // namespace deja_view::internal
#endif
