#include "deja_view/base/error_policy.hpp"

#include <stdexcept>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using testing::ElementsAre;

class ErrorPolicyTest : public testing::Test {
 protected:
  std::vector<std::string> told_;
  ErrorPolicy errors_{[this](const std::string& what) { told_.push_back(what); }};
};

TEST_F(ErrorPolicyTest, BadInputIsToldCountedAndPassedOver) {
  EXPECT_TRUE(errors_.Guard([] {}));
  EXPECT_FALSE(errors_.Guard([] { ThrowInputError("/odometry: not a number"); }));
  EXPECT_THAT(told_, ElementsAre("/odometry: not a number"));
  EXPECT_EQ(errors_.bad_inputs(), 1);
  EXPECT_FALSE(errors_.has_failed());
  EXPECT_NO_THROW(errors_.RethrowFailure());
}

TEST_F(ErrorPolicyTest, TheFirstBrokenInvariantIsKeptForTheMainThread) {
  std::thread([this] {
    EXPECT_FALSE(errors_.Guard([] { DEJA_VIEW_CHECK_OP(1, ==, 2); }));
    EXPECT_FALSE(errors_.Guard([] { throw std::bad_alloc(); }));
  }).join();
  EXPECT_TRUE(errors_.has_failed());
  EXPECT_THROW(errors_.RethrowFailure(), CheckError);
  EXPECT_THAT(told_, ElementsAre());
  EXPECT_EQ(errors_.bad_inputs(), 0);
}

}  // namespace
}  // namespace deja_view
