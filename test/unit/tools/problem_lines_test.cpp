#include "common/problem_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(ProblemLines, AreOnePerKindInOrder) {
  EXPECT_THAT(ProblemLines({"keyframe 1403715317312143104: 10x10, expected 752x480",
                            "message of stamp 7 ns: duplicate",
                            "keyframe 1403715318312143104: 10x10, expected 752x480",
                            "keyframe 1403715319312143104: 10x10, expected 752x480"}),
              ElementsAre("keyframe 1403715317312143104: 10x10, expected 752x480 "
                          "(and 2 more like it)",
                          "message of stamp 7 ns: duplicate"));
}

TEST(ProblemLines, TellSizesApart) {
  EXPECT_THAT(ProblemLines({"10x10", "10x11"}), ElementsAre("10x10", "10x11"));
  EXPECT_THAT(ProblemLines({}), IsEmpty());
}

}  // namespace
}  // namespace deja_view
