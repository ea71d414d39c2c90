#include "accumulate.hpp"

#include <algorithm>
#include <type_traits>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

// GCC 12's own AVX-512 headers use a vector that was never set, on purpose (GCC bug 105593).
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

namespace deja_view::internal {
namespace {

// 16 kB of 32-bit sums
constexpr std::uint32_t kPartWords = 4096 / 32;

template <typename Sum>
void AddBitmapPortable(const std::uint32_t* bitmap, std::uint32_t words, Sum weight, Sum* sums) {
  for (std::uint32_t word = 0; word < words; ++word, sums += 32) {
    for (std::uint32_t bits = bitmap[word]; bits != 0; bits &= bits - 1) {
      sums[__builtin_ctz(bits)] += weight;
    }
  }
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void AddBitmapAvx2(const std::uint32_t* bitmap,
                                                   std::uint32_t words,
                                                   std::uint32_t weight,
                                                   std::uint32_t* sums) {
  const __m256i weights = _mm256_set1_epi32(static_cast<int>(weight));
  const __m256i lanes = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  for (std::uint32_t word = 0; word < words; ++word) {
    for (std::uint32_t bits = bitmap[word], i = word * 32; bits != 0; bits >>= 8U, i += 8) {
      const __m256i selected = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(bits)), lanes);
      const __m256i mask = _mm256_cmpeq_epi32(selected, lanes);
      auto* sum = reinterpret_cast<__m256i*>(sums + i);
      _mm256_storeu_si256(
          sum, _mm256_add_epi32(_mm256_loadu_si256(sum), _mm256_and_si256(mask, weights)));
    }
  }
}

__attribute__((target("avx512f"))) void AddBitmapAvx512(const std::uint32_t* bitmap,
                                                        std::uint32_t words,
                                                        std::uint32_t weight,
                                                        std::uint32_t* sums) {
  const __m512i weights = _mm512_set1_epi32(static_cast<int>(weight));
  for (std::uint32_t word = 0; word < words; ++word, sums += 32) {
    const std::uint32_t bits = bitmap[word];
    const __m512i low = _mm512_loadu_si512(sums);
    const __m512i high = _mm512_loadu_si512(sums + 16);
    _mm512_storeu_si512(sums,
                        _mm512_mask_add_epi32(low, static_cast<__mmask16>(bits), low, weights));
    _mm512_storeu_si512(
        sums + 16, _mm512_mask_add_epi32(high, static_cast<__mmask16>(bits >> 16U), high, weights));
  }
}

__attribute__((target("avx512f"))) void AddBitmap64Avx512(const std::uint32_t* bitmap,
                                                          std::uint32_t words,
                                                          std::uint64_t weight,
                                                          std::uint64_t* sums) {
  const __m512i weights = _mm512_set1_epi64(static_cast<std::int64_t>(weight));
  for (std::uint32_t word = 0; word < words; ++word) {
    for (std::uint32_t bits = bitmap[word], i = word * 32; bits != 0; bits >>= 8U, i += 8) {
      const __m512i sum = _mm512_loadu_si512(sums + i);
      _mm512_storeu_si512(sums + i,
                          _mm512_mask_add_epi64(sum, static_cast<__mmask8>(bits), sum, weights));
    }
  }
}
#endif

}  // namespace

std::vector<AccumulateKernel> AvailableAccumulateKernels() {
  std::vector<AccumulateKernel> kernels;
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f")) {
    kernels.push_back({"avx512", &AddBitmapAvx512, &AddBitmap64Avx512});
  }
  if (__builtin_cpu_supports("avx2")) {
    kernels.push_back({"avx2", &AddBitmapAvx2, &AddBitmapPortable<std::uint64_t>});
  }
#endif
  kernels.push_back(
      {"portable", &AddBitmapPortable<std::uint32_t>, &AddBitmapPortable<std::uint64_t>});
  return kernels;
}

template <typename Sum>
void Accumulator<Sum>::Finish() {
  const std::uint32_t words = (slots_ + 31) / 32;
  for (std::uint32_t begin = 0; begin < words; begin += kPartWords) {
    for (const Bitmap& bitmap : bitmaps_) {
      const std::uint32_t end = std::min({bitmap.words, begin + kPartWords, words});
      if (begin < end) {
        const std::uint32_t* bits = bitmap.bits + begin;
        Sum* sums = bitmap.sums + begin * 32;
        if constexpr (std::is_same_v<Sum, std::uint32_t>) {
          kernel_.add_bitmap(bits, end - begin, bitmap.weight, sums);
        } else {
          kernel_.add_bitmap_64(bits, end - begin, bitmap.weight, sums);
        }
      }
    }
  }
  bitmaps_.clear();
}

template class Accumulator<std::uint32_t>;
template class Accumulator<std::uint64_t>;

}  // namespace deja_view::internal
