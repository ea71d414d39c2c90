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

// Distances of four children in the order [0 2 0 2 1 3 1 3], from the words of two pairs of them.
inline WordVector QuartetDistances(WordVector twice, WordVector pair0, WordVector pair1) {
  const Words d;
  const auto p0 = hn::PopulationCount(hn::Xor(twice, pair0));
  const auto p1 = hn::PopulationCount(hn::Xor(twice, pair1));
  const auto sums = hn::Add(hn::InterleaveLower(d, p0, p1), hn::InterleaveUpper(d, p0, p1));
  return hn::Add(sums, hn::SwapAdjacentBlocks(sums));
}

// The places of eight children in their vector of distances.
inline WordVector Order() {
  alignas(64) static constexpr std::uint64_t kOrder[8] = {0, 2, 4, 6, 1, 3, 5, 7};
  return hn::Load(Words(), kOrder);
}

// Keys of eight children, whose words `load` gives by pairs.
template <typename Load>
inline WordVector OctetKeys(WordVector twice, std::uint32_t base, const Load& load) {
  const auto distances = hn::OddEvenBlocks(QuartetDistances(twice, load(4), load(6)),
                                           QuartetDistances(twice, load(0), load(2)));
  return hn::Or(hn::ShiftLeft<32>(distances), hn::Add(Order(), hn::Set(Words(), base)));
}

inline std::uint32_t NearestChild(const Descriptor& descriptor,
                                  const Descriptor* children,
                                  std::uint32_t count) {
  const Words d;
  const hn::FixedTag<std::uint64_t, 4> half;
  const auto once = hn::LoadU(half, descriptor.words.data());
  const auto twice = hn::Combine(d, once, once);
  auto best = hn::Set(d, ~std::uint64_t{0});
  std::uint32_t base = 0;
  for (; base + 8 <= count; base += 8) {
    const auto load = [&](std::uint32_t i) {
      return hn::LoadU(d, children[base + i].words.data());
    };
    best = hn::Min(best, OctetKeys(twice, base, load));
  }
  if (base < count) {
    const std::uint32_t rest = count - base;
    const auto load = [&](std::uint32_t i) {
      const auto mask = hn::FirstN(d, rest > i ? std::min(rest - i, 2U) * 4 : 0U);
      return hn::MaskedLoad(mask, d, (children + base + std::min(i, rest))->words.data());
    };
    const auto is_there = hn::Lt(Order(), hn::Set(d, rest));
    best = hn::Min(best, hn::IfThenElse(is_there, OctetKeys(twice, base, load), best));
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
