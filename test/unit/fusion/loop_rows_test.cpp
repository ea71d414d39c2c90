#include "deja_view/fusion/loop_rows.hpp"

#include "deja_view/base/check.hpp"

#include <filesystem>
#include <set>
#include <utility>
#include <vector>

#include "temporary_directory.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

class LoopRowsTest : public TemporaryDirectoryTest {
 protected:
  static constexpr int kMany = 10000;

  static void AddMany(LoopRows* rows) {
    for (int i = 0; i < kMany; ++i) {
      LoopRow row;
      row.old = i;
      row.current = i + 1;
      row.inliers = i % 50;
      row.reason = i % 2 == 0 ? RejectReason::kNone : RejectReason::kInconsistent;
      rows->Add(row);
    }
  }
  static std::vector<LoopRow> List(const LoopRows& rows) {
    std::vector<LoopRow> list;
    rows.ForEach([&list](const LoopRow& row) { list.push_back(row); });
    return list;
  }
  static void ExpectMany(const LoopRows& rows, const std::set<int>& withdrawn) {
    ASSERT_EQ(rows.size(), static_cast<std::size_t>(kMany));
    const std::vector<LoopRow> list = List(rows);
    ASSERT_EQ(list.size(), rows.size());
    for (int i = 0; i < kMany; ++i) {
      const LoopRow& row = list[static_cast<std::size_t>(i)];
      ASSERT_EQ(row.old, i);
      ASSERT_EQ(row.current, i + 1);
      ASSERT_EQ(row.inliers, i % 50);
      ASSERT_EQ(row.reason,
                withdrawn.count(i) > 0 ? RejectReason::kWithdrawn
                : i % 2 == 0           ? RejectReason::kNone
                                       : RejectReason::kInconsistent);
    }
  }
};

TEST_F(LoopRowsTest, KeepsFewInMemoryAndLosesNone) {
  LoopRows rows(directory_);
  AddMany(&rows);
  EXPECT_LT(rows.in_memory(), kMany / 2);
  EXPECT_TRUE(std::filesystem::is_empty(directory_)) << "the file has no name";
  ExpectMany(rows, {});
}

TEST_F(LoopRowsTest, WithdrawsOldOnesAndNewOnes) {
  LoopRows rows(directory_);
  AddMany(&rows);
  rows.Withdraw({{0, 1}, {4000, 4001}, {kMany - 2, kMany - 1}});
  ExpectMany(rows, {0, 4000, kMany - 2});
  EXPECT_THROW(rows.Withdraw({{0, 1}}), CheckError) << "it is withdrawn already";
  EXPECT_THROW(rows.Withdraw({{1, 2}}), CheckError) << "it was never accepted";
}

TEST_F(LoopRowsTest, WithdrawsTheNewestOfTheSameLoop) {
  LoopRows rows(directory_);
  AddMany(&rows);
  LoopRow again;
  again.old = 0;
  again.current = 1;
  rows.Add(again);
  rows.Withdraw({{0, 1}});
  const std::vector<LoopRow> list = List(rows);
  EXPECT_TRUE(list.front().accepted());
  EXPECT_FALSE(list.back().accepted());
}

TEST_F(LoopRowsTest, StayInMemoryWhereNoFileCanBe) {
  LoopRows rows(directory_ / "missing");
  AddMany(&rows);
  EXPECT_EQ(rows.in_memory(), rows.size());
  rows.Withdraw({{0, 1}});
  ExpectMany(rows, {0});
}

TEST(LoopRowTest, IsSmall) {
  EXPECT_LE(sizeof(LoopRow), 72U) << "a flight of ten hours has some hundred thousand";
}

}  // namespace
}  // namespace deja_view
