#include "deja_view/base/parallel.hpp"

#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

class ParallelForTest : public ::testing::TestWithParam<int> {};

TEST_P(ParallelForTest, VisitsEveryIndexOnce) {
  std::vector<int> visits(1001, 0);
  ParallelFor(GetParam(), visits.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      ++visits[i];
    }
  });
  EXPECT_THAT(visits, ::testing::Each(1));
}

TEST_P(ParallelForTest, HandsExceptionsToTheCaller) {
  EXPECT_THROW(
      ParallelFor(
          GetParam(), 10, [](std::size_t, std::size_t) { throw std::runtime_error("boom"); }),
      std::runtime_error);
}

INSTANTIATE_TEST_SUITE_P(Threads, ParallelForTest, ::testing::Values(0, 1, 2, 5));

TEST(ParallelFor, DoesNothingForAnEmptyRange) {
  bool called = false;
  ParallelFor(1, 0, [&](std::size_t, std::size_t) { called = true; });
  EXPECT_FALSE(called);
}

}  // namespace
}  // namespace deja_view
