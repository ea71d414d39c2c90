#pragma once

// For loops over the lanes of a packet that are written as plain C++ without branches: an inline
// body is compiled once for the baseline and once, inlined into a function marked
// DEJA_VIEW_SIM_TARGET_AVX2, for AVX2. Operations are not fused or reordered, so that both give the
// same bits.
#if defined(__x86_64__) && defined(__GNUC__)
#define DEJA_VIEW_SIM_TARGET_AVX2 __attribute__((target("avx2")))
#define DEJA_VIEW_SIM_INLINE inline __attribute__((always_inline))
#else
#define DEJA_VIEW_SIM_TARGET_AVX2
#define DEJA_VIEW_SIM_INLINE inline
#endif

namespace deja_view::sim {

/// True when this machine runs functions marked DEJA_VIEW_SIM_TARGET_AVX2.
inline bool HasAvx2() {
#if defined(__x86_64__) && defined(__GNUC__)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return true;
#endif
}

}  // namespace deja_view::sim
