#include "descend.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

// GCC 12's own AVX-512 headers use a vector that was never set, on purpose (GCC bug 105593).
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

namespace deja_view::internal {
namespace {

namespace portable {
#define DEJA_VIEW_TARGET

inline int Distance(const Descriptor& a, const Descriptor& b) {
  return HammingDistance(a, b);
}

inline std::uint32_t NearestChild(const Descriptor& descriptor,
                                  const Descriptor* children,
                                  std::uint32_t count) {
  std::uint32_t best = 0;
  int best_distance = HammingDistance(descriptor, children[0]);
  for (std::uint32_t i = 1; i < count; ++i) {
    const int distance = HammingDistance(descriptor, children[i]);
    if (distance < best_distance) {
      best_distance = distance;
      best = i;
    }
  }
  return best;
}

#include "descend.inc"
#undef DEJA_VIEW_TARGET
}  // namespace portable

#if defined(__x86_64__)
namespace popcnt {
#define DEJA_VIEW_TARGET __attribute__((target("popcnt")))

DEJA_VIEW_TARGET inline std::int64_t Distance(const Descriptor& a, const Descriptor& b) {
  return _mm_popcnt_u64(a.words[0] ^ b.words[0]) + _mm_popcnt_u64(a.words[1] ^ b.words[1]) +
         _mm_popcnt_u64(a.words[2] ^ b.words[2]) + _mm_popcnt_u64(a.words[3] ^ b.words[3]);
}

DEJA_VIEW_TARGET inline std::uint32_t NearestChild(const Descriptor& descriptor,
                                                   const Descriptor* children,
                                                   std::uint32_t count) {
  // Distance above, index below: the least key is the nearest child, of equally near ones the
  // first.
  std::uint64_t best = ~std::uint64_t{0};
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto distance = static_cast<std::uint64_t>(Distance(descriptor, children[i]));
    const std::uint64_t key = distance << 32U | i;
    best = key < best ? key : best;
  }
  return static_cast<std::uint32_t>(best);
}

#include "descend.inc"
#undef DEJA_VIEW_TARGET
}  // namespace popcnt

namespace avx512 {
#define DEJA_VIEW_TARGET __attribute__((target("avx512f,avx512vpopcntdq,popcnt")))

DEJA_VIEW_TARGET inline std::int64_t Distance(const Descriptor& a, const Descriptor& b) {
  return popcnt::Distance(a, b);
}

// Bits that differ, per 64-bit word, of two children (or one, when `mask` leaves out the upper
// half).
DEJA_VIEW_TARGET inline __m512i PairCounts(__m512i descriptor,
                                           const Descriptor* children,
                                           __mmask8 mask) {
  return _mm512_popcnt_epi64(
      _mm512_maskz_xor_epi64(mask, descriptor, _mm512_maskz_loadu_epi64(mask, children)));
}

// Keys (distance above, index below) of children [base, base + 8), all ones where there is none.
DEJA_VIEW_TARGET inline __m512i OctetKeys(__m512i descriptor,
                                          const Descriptor* children,
                                          std::uint32_t base,
                                          std::uint32_t count) {
  const std::uint32_t here = count - base < 8 ? count - base : 8;
  const std::uint32_t words = (std::uint32_t{1} << (here * 4 % 32)) - 1U + (here == 8 ? ~0U : 0U);
  const auto mask = [words](int pair) { return static_cast<__mmask8>(words >> (8 * pair)); };
  const Descriptor* c = children + base;
  const __m512i p0 = PairCounts(descriptor, c, mask(0));
  const __m512i p1 = PairCounts(descriptor, c + 2, mask(1));
  const __m512i p2 = PairCounts(descriptor, c + 4, mask(2));
  const __m512i p3 = PairCounts(descriptor, c + 6, mask(3));
  // Sums of words 0+1 and 2+3, in the order [0 2 0 2 1 3 1 3] of the children of p0, p1 (p2, p3: +
  // 4).
  const __m512i s0 = _mm512_add_epi64(_mm512_unpacklo_epi64(p0, p1), _mm512_unpackhi_epi64(p0, p1));
  const __m512i s1 = _mm512_add_epi64(_mm512_unpacklo_epi64(p2, p3), _mm512_unpackhi_epi64(p2, p3));
  const __m512i low = _mm512_setr_epi64(0, 1, 4, 5, 8, 9, 12, 13);
  const __m512i high = _mm512_setr_epi64(2, 3, 6, 7, 10, 11, 14, 15);
  const __m512i distances = _mm512_add_epi64(_mm512_permutex2var_epi64(s0, low, s1),
                                             _mm512_permutex2var_epi64(s0, high, s1));
  const __m512i order = _mm512_setr_epi64(0, 2, 1, 3, 4, 6, 5, 7);
  const __m512i keys = _mm512_or_epi64(_mm512_slli_epi64(distances, 32),
                                       _mm512_add_epi64(order, _mm512_set1_epi64(base)));
  const __mmask8 present = _mm512_cmplt_epu64_mask(order, _mm512_set1_epi64(here));
  return _mm512_mask_mov_epi64(_mm512_set1_epi64(-1), present, keys);
}

DEJA_VIEW_TARGET inline std::uint32_t NearestChild(const Descriptor& descriptor,
                                                   const Descriptor* children,
                                                   std::uint32_t count) {
  const __m512i twice = _mm512_broadcast_i64x4(
      _mm256_loadu_si256(reinterpret_cast<const __m256i*>(descriptor.words.data())));
  __m512i best = OctetKeys(twice, children, 0, count);
  for (std::uint32_t base = 8; base < count; base += 8) {
    best = _mm512_min_epu64(best, OctetKeys(twice, children, base, count));
  }
  return static_cast<std::uint32_t>(_mm512_reduce_min_epu64(best));
}

#include "descend.inc"
#undef DEJA_VIEW_TARGET
}  // namespace avx512
#endif

}  // namespace

std::vector<DescendKernel> AvailableDescendKernels() {
  std::vector<DescendKernel> kernels;
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vpopcntdq")) {
    kernels.push_back({"avx512", &avx512::Descend, &avx512::Assign, &avx512::Lower});
  }
  if (__builtin_cpu_supports("popcnt")) {
    kernels.push_back({"popcnt", &popcnt::Descend, &popcnt::Assign, &popcnt::Lower});
  }
#endif
  kernels.push_back({"portable", &portable::Descend, &portable::Assign, &portable::Lower});
  return kernels;
}

}  // namespace deja_view::internal
