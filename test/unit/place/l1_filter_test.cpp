#include "l1_filter.hpp"

#include <random>

#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

TEST(L1FilterKernels, PassWhatReachesTheThreshold) {
  constexpr std::uint32_t kSlots = 800;
  std::mt19937_64 rng(1);
  std::vector<std::uint32_t> norms(kSlots);
  std::vector<std::uint32_t> once(kSlots);
  std::vector<std::uint32_t> more(kSlots);
  std::vector<std::uint32_t> repeats(kSlots);
  std::vector<std::uint64_t> rest(kSlots);
  const std::uint64_t norm = 20000000;
  for (std::uint32_t slot = 0; slot < kSlots; ++slot) {
    norms[slot] = static_cast<std::uint32_t>(rng() % (3 * norm));
    if (slot % 5 != 0) {  // the others have nothing in common
      once[slot] = static_cast<std::uint32_t>(rng() % 6000000);
      more[slot] = static_cast<std::uint32_t>(rng() % 1000000);
      repeats[slot] = static_cast<std::uint32_t>(rng() % 500000);
      rest[slot] = rng() % (500000 * norm);
    }
  }
  const L1Parts parts = {norm, norms.data(), once.data(), more.data(), repeats.data(), rest.data()};
  for (const double threshold : {0.0, 0.1, 0.2, 0.9}) {
    std::vector<std::uint32_t> expected;
    for (std::uint32_t slot = 80; slot < 720; ++slot) {
      const double scale = static_cast<double>(norm) * static_cast<double>(norms[slot]);
      const std::uint64_t common = parts.Common(slot);
      if (common > 0 && static_cast<double>(common) >= threshold * scale) {
        expected.push_back(slot);
      }
    }
    for (const L1FilterKernel& kernel : AvailableL1FilterKernels()) {
      std::vector<std::uint32_t> found(kSlots);
      found.resize(kernel.filter(parts, threshold, 80, 720, found.data()));
      EXPECT_EQ(found, expected) << kernel.name << " " << threshold;
    }
  }
}

}  // namespace
}  // namespace deja_view::internal
