#include "deja_view/base/shard.hpp"

#include "deja_view/base/check.hpp"

#include <gtest/gtest.h>

namespace deja_view {
namespace {

TEST(ShardTest, ReadsIndexAndCount) {
  EXPECT_EQ(ParseShard("--shard", "0/1"), (Shard{0, 1}));
  EXPECT_EQ(ParseShard("--shard", "7/8"), (Shard{7, 8}));
  EXPECT_NE(ParseShard("--shard", "7/8"), (Shard{7, 9}));
}

TEST(ShardTest, RefusesAllElse) {
  for (const char* text :
       {"", "1", "2/2", "-1/2", "0/0", "0/-1", "0/2 ", "0/2/3", "a/b", "0/100001", "1.5/2"}) {
    EXPECT_THROW(ParseShard("--shard", text), InputError) << text;
  }
  try {
    ParseShard("--shard", "2/2");
  } catch (const InputError& e) {
    EXPECT_STREQ(e.what(), "--shard 2/2: expected i/n with i from 0 to n - 1");
  }
}

}  // namespace
}  // namespace deja_view
