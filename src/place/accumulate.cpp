#include "accumulate.hpp"

#include <algorithm>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

// GCC 12's own AVX-512 headers use a vector that was never set, on purpose (GCC bug 105593).
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

namespace deja_view::internal {
namespace {

template <typename Sum>
void AddBitmapsPortable(const std::vector<WeightedBitmap<Sum>>& bitmaps, Sum* sums) {
  for (const WeightedBitmap<Sum>& bitmap : bitmaps) {
    Sum* here = sums;
    for (std::uint32_t word = 0; word < bitmap.words; ++word, here += 32) {
      for (std::uint32_t bits = bitmap.bits[word]; bits != 0; bits &= bits - 1) {
        here[__builtin_ctz(bits)] += bitmap.weight;
      }
    }
  }
}

template <typename Sum>
std::uint32_t MostWords(const std::vector<WeightedBitmap<Sum>>& bitmaps) {
  std::uint32_t words = 0;
  for (const WeightedBitmap<Sum>& bitmap : bitmaps) {
    words = std::max(words, bitmap.words);
  }
  return words;
}

#if defined(__x86_64__)
// 64 slots at a time in eight registers.
__attribute__((target("avx2"))) void AddBitmapsAvx2(
    const std::vector<WeightedBitmap<std::uint32_t>>& bitmaps, std::uint32_t* sums) {
  const __m256i lanes = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  const std::uint32_t words = MostWords(bitmaps);
  for (std::uint32_t word = 0; word < words; word += 2) {
    auto* here = reinterpret_cast<__m256i*>(sums + word * 32);
    __m256i sum[8];
    for (int i = 0; i < 8; ++i) {
      sum[i] = _mm256_loadu_si256(here + i);
    }
    for (const WeightedBitmap<std::uint32_t>& bitmap : bitmaps) {
      if (word >= bitmap.words) {
        continue;
      }
      const __m256i weight = _mm256_set1_epi32(static_cast<int>(bitmap.weight));
      for (unsigned i = 0; i < 8; ++i) {
        const auto bits = static_cast<int>(bitmap.bits[word + i / 4] >> (8 * (i % 4)));
        const __m256i mask =
            _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(bits), lanes), lanes);
        sum[i] = _mm256_add_epi32(sum[i], _mm256_and_si256(mask, weight));
      }
    }
    for (int i = 0; i < 8; ++i) {
      _mm256_storeu_si256(here + i, sum[i]);
    }
  }
}

// A block of 128 slots at a time in eight registers.
__attribute__((target("avx512f"))) void AddBitmapsAvx512(
    const std::vector<WeightedBitmap<std::uint32_t>>& bitmaps, std::uint32_t* sums) {
  const std::uint32_t words = MostWords(bitmaps);
  for (std::uint32_t word = 0; word < words; word += kBlockWords) {
    std::uint32_t* here = sums + word * 32;
    __m512i sum[2 * kBlockWords];
    for (unsigned i = 0; i < 2 * kBlockWords; ++i) {
      sum[i] = _mm512_loadu_si512(here + 16 * i);
    }
    for (const WeightedBitmap<std::uint32_t>& bitmap : bitmaps) {
      if (word >= bitmap.words) {
        continue;
      }
      const std::uint32_t* bits = bitmap.bits + word;
      __builtin_prefetch(bits + 16);
      const __m512i weight = _mm512_set1_epi32(static_cast<int>(bitmap.weight));
      for (unsigned i = 0; i < 2 * kBlockWords; ++i) {
        const auto mask = static_cast<__mmask16>(bits[i / 2] >> (16 * (i % 2)));
        sum[i] = _mm512_mask_add_epi32(sum[i], mask, sum[i], weight);
      }
    }
    for (unsigned i = 0; i < 2 * kBlockWords; ++i) {
      _mm512_storeu_si512(here + 16 * i, sum[i]);
    }
  }
}

// 64 slots at a time in eight registers.
__attribute__((target("avx512f"))) void AddBitmaps64Avx512(
    const std::vector<WeightedBitmap<std::uint64_t>>& bitmaps, std::uint64_t* sums) {
  const std::uint32_t words = MostWords(bitmaps);
  for (std::uint32_t word = 0; word < words; word += 2) {
    std::uint64_t* here = sums + word * 32;
    __m512i sum[8];
    for (unsigned i = 0; i < 8; ++i) {
      sum[i] = _mm512_loadu_si512(here + 8 * i);
    }
    for (const WeightedBitmap<std::uint64_t>& bitmap : bitmaps) {
      if (word >= bitmap.words) {
        continue;
      }
      const std::uint32_t* bits = bitmap.bits + word;
      __builtin_prefetch(bits + 16);
      const __m512i weight = _mm512_set1_epi64(static_cast<std::int64_t>(bitmap.weight));
      for (unsigned i = 0; i < 8; ++i) {
        const auto mask = static_cast<__mmask8>(bits[i / 4] >> (8 * (i % 4)));
        sum[i] = _mm512_mask_add_epi64(sum[i], mask, sum[i], weight);
      }
    }
    for (unsigned i = 0; i < 8; ++i) {
      _mm512_storeu_si512(here + 8 * i, sum[i]);
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
    kernels.push_back({"avx512", &AddBitmapsAvx512, &AddBitmaps64Avx512});
  }
  if (__builtin_cpu_supports("avx2")) {
    kernels.push_back({"avx2", &AddBitmapsAvx2, &AddBitmapsPortable<std::uint64_t>});
  }
#endif
  kernels.push_back(
      {"portable", &AddBitmapsPortable<std::uint32_t>, &AddBitmapsPortable<std::uint64_t>});
  return kernels;
}

}  // namespace deja_view::internal
