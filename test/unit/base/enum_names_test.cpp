#include "deja_view/base/enum_names.hpp"

#include <gtest/gtest.h>

namespace deja_view {

enum class Fruit { kApple, kFig, kPlum };

template <>
inline constexpr auto kEnumNames<Fruit> = EnumNames("apple", "fig", "plum");

namespace {

TEST(EnumNames, GoInTheOrderOfTheValues) {
  EXPECT_EQ(EnumToString(Fruit::kApple), "apple");
  EXPECT_EQ(EnumToString(Fruit::kPlum), "plum");
  EXPECT_EQ(EnumFromString<Fruit>("fig"), Fruit::kFig);
  EXPECT_EQ(EnumNameList<Fruit>(), "apple, fig, plum");
}

TEST(EnumNames, AValueOrANameMayBeNone) {
  EXPECT_EQ(EnumToString(static_cast<Fruit>(3)), "?");
  EXPECT_EQ(EnumToString(static_cast<Fruit>(-1)), "?");
  EXPECT_FALSE(EnumFromString<Fruit>("figs").has_value());
  EXPECT_FALSE(EnumFromString<Fruit>("").has_value());
}

}  // namespace
}  // namespace deja_view
