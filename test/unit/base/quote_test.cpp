#include "deja_view/base/quote.hpp"

#include <string>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

TEST(Quote, LeavesPlainTextAlone) {
  EXPECT_EQ(Quote(""), "''");
  EXPECT_EQ(Quote("K\xC3\xBC"
                  "che 12"),
            "'K\xC3\xBC"
            "che 12'");
}

TEST(Quote, EscapesControlCharacters) {
  EXPECT_EQ(Quote("a\nb\tc\x1b[31m\x7F"), "'a\\nb\\tc\\x1b[31m\\x7f'");
  EXPECT_EQ(Quote(std::string("\0", 1)), "'\\x00'");
}

TEST(Quote, BoundsLongText) {
  EXPECT_EQ(Quote("abcdef", 6), "'abcdef'");
  EXPECT_EQ(Quote("abcdefg", 6), "'abcdef...' (7 bytes)");
  EXPECT_LT(Quote(std::string(100000, '\n')).size(), 200U);
}

TEST(Quote, DoesNotCutALetter) {
  EXPECT_EQ(Quote("ab\xC3\xBC", 3), "'ab...' (4 bytes)");
  EXPECT_EQ(Quote("\x80\x80\x80", 1), "'...' (3 bytes)");
}

}  // namespace
}  // namespace deja_view
