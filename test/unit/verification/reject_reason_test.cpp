#include "deja_view/verification/reject_reason.hpp"

#include <set>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

TEST(RejectReason, EveryValueHasItsOwnName) {
  std::set<std::string> names;
  for (int i = 0; i < kRejectReasonCount; ++i) {
    const std::string name = EnumToString(static_cast<RejectReason>(i));
    EXPECT_NE(name, "?") << i;
    EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_"), std::string::npos) << name;
    EXPECT_TRUE(names.insert(name).second) << name;
  }
  EXPECT_EQ(EnumToString(RejectReason::kNone), "accepted");
  EXPECT_EQ(EnumToString(static_cast<RejectReason>(kRejectReasonCount)), "?");
}

}  // namespace
}  // namespace deja_view
