#include "deja_view/base/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(Check, ThrowsWithBothValues) {
  try {
    DEJA_VIEW_CHECK_OP(3, <, 2);
    FAIL() << "no exception";
  } catch (const CheckError& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("3 < 2"), HasSubstr("3 vs. 2"), HasSubstr("check_test")));
  }
}

TEST(Check, PassesSilently) {
  EXPECT_NO_THROW(DEJA_VIEW_CHECK(1 + 1 == 2));
  EXPECT_NO_THROW(DEJA_VIEW_CHECK_OP(2, ==, 2));
  EXPECT_THROW(DEJA_VIEW_CHECK(1 + 1 == 3), CheckError);
}

TEST(Check, InputErrorIsFormatted) {
  try {
    ThrowInputError("{}: expected {}", "a.yaml", 3);
  } catch (const InputError& e) {
    EXPECT_STREQ(e.what(), "a.yaml: expected 3");
  }
}

}  // namespace
}  // namespace deja_view
