#include "deja_view/io/seconds.hpp"

#include "deja_view/base/check.hpp"

#include <cstdint>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

TEST(ParseSeconds, IsExactToTheNanosecond) {
  EXPECT_EQ(ParseSeconds("1403636625.838560104"), 1403636625838560104);
  EXPECT_EQ(ParseSeconds("1403715274.30214"), 1403715274302140000);
  EXPECT_EQ(ParseSeconds("12"), 12000000000);
  EXPECT_EQ(ParseSeconds("0.000000001"), 1);
  EXPECT_EQ(ParseSeconds(".5"), 500000000);
  EXPECT_EQ(ParseSeconds("5."), 5000000000);
  EXPECT_EQ(ParseSeconds("0.0000000014"), 1);
  EXPECT_EQ(ParseSeconds("0.0000000015"), 2);
  EXPECT_EQ(ParseSeconds("1.403636625838560104e+09"), 1403636625838560104);
  EXPECT_EQ(ParseSeconds("14036366258385601E-7"), 1403636625838560100);
  EXPECT_EQ(ParseSeconds("1e-12"), 0);
  EXPECT_EQ(ParseSeconds("9223372036.854775806"), INT64_MAX - 1);
}

TEST(ParseSeconds, RefusesOtherText) {
  for (const char* text : {"",
                           ".",
                           "-1",
                           "+1",
                           "1,5",
                           "1.2.3",
                           "nan",
                           "inf",
                           "0x10",
                           "1e",
                           "1e+",
                           "1e99",
                           "9223372037",
                           "1 ",
                           "e5",
                           "11111111111111111111111111111111111111111111"}) {
    EXPECT_FALSE(ParseSeconds(text).has_value()) << text;
  }
}

TEST(FormatSeconds, KeepsEveryNanosecond) {
  EXPECT_EQ(FormatSeconds(1403636625838560104), "1403636625.838560104");
  EXPECT_EQ(FormatSeconds(7), "0.000000007");
  EXPECT_THROW(FormatSeconds(-1), CheckError);
}

}  // namespace
}  // namespace deja_view
