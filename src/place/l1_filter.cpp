#include "l1_filter.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

// GCC 12's own AVX-512 headers use a vector that was never set, on purpose (GCC bug 105593).
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

namespace deja_view::internal {
namespace {

// Doubles round a common sum of up to 62 bits by far less than this.
constexpr double kSlack = 1 - 1e-9;

std::uint32_t FilterPortable(const L1Parts& parts,
                             double threshold,
                             std::uint32_t begin,
                             std::uint32_t end,
                             std::uint32_t* found) {
  const double factor = threshold * kSlack * static_cast<double>(parts.norm);
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

#if defined(__x86_64__)
__attribute__((target("avx512f,avx512dq,avx512vl"))) inline __m512d LoadDoubles(
    const std::uint32_t* values) {
  return _mm512_cvtepu32_pd(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(values)));
}

__attribute__((target("avx512f,avx512dq,avx512vl"))) std::uint32_t FilterAvx512(
    const L1Parts& parts,
    double threshold,
    std::uint32_t begin,
    std::uint32_t end,
    std::uint32_t* found) {
  const __m512d norm = _mm512_set1_pd(static_cast<double>(parts.norm));
  const __m512d norm_twice = _mm512_add_pd(norm, norm);
  const __m512d factor = _mm512_set1_pd(threshold * kSlack * static_cast<double>(parts.norm));
  std::uint32_t count = 0;
  for (std::uint32_t slot = begin; slot < end; slot += kFilterBlock) {
    const __m512d b = LoadDoubles(parts.norms + slot);
    const __m512d least = _mm512_min_pd(b, norm);
    const __m512d twice = _mm512_sub_pd(_mm512_min_pd(b, norm_twice), least);
    __m512d common = _mm512_cvtepi64_pd(_mm512_loadu_si512(parts.rest + slot));
    common = _mm512_add_pd(common, _mm512_mul_pd(LoadDoubles(parts.once + slot), least));
    common = _mm512_add_pd(common, _mm512_mul_pd(LoadDoubles(parts.more + slot), norm));
    common = _mm512_add_pd(common, _mm512_mul_pd(LoadDoubles(parts.repeats + slot), twice));
    const __mmask8 passes = _mm512_cmp_pd_mask(common, _mm512_mul_pd(factor, b), _CMP_GE_OQ) &
                            _mm512_cmp_pd_mask(common, _mm512_set1_pd(0.5), _CMP_GE_OQ);
    for (unsigned bits = passes; bits != 0; bits &= bits - 1) {
      found[count++] = slot + static_cast<std::uint32_t>(__builtin_ctz(bits));
    }
  }
  return count;
}
#endif

}  // namespace

std::vector<L1FilterKernel> AvailableL1FilterKernels() {
  std::vector<L1FilterKernel> kernels;
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
    kernels.push_back({"avx512", &FilterAvx512});
  }
#endif
  kernels.push_back({"portable", &FilterPortable});
  return kernels;
}

}  // namespace deja_view::internal
