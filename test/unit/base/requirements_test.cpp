#include "deja_view/base/requirements.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(RequirementsTest, KeepsSilentWhenAllHolds) {
  Requirements r;
  r.That(true, "a must be positive");
  r.That(true, "b", 3, "more than 2");
  r.Range("c", 1, 1, 1);
  r.Group("d", {});
  EXPECT_THAT(r.errors(), IsEmpty());
  EXPECT_NO_THROW(CheckNone(r.errors(), "options"));
  EXPECT_NO_THROW(RejectAny(r.errors(), "options"));
}

TEST(RequirementsTest, CollectsAllViolations) {
  Requirements r;
  r.That(false, "a must be positive");
  r.That(false, "b", 1.5, "more than 2");
  r.Range("c", 17, 1, 16);
  r.Range("d", NAN, 0.0, 1.0);
  r.Group("e", {"f: 0, expected 1 to 2"});
  EXPECT_THAT(r.errors(),
              ElementsAre("a must be positive",
                          "b: 1.5, expected more than 2",
                          "c: 17, expected 1 to 16",
                          "d: nan, expected 0 to 1",
                          "e.f: 0, expected 1 to 2"));
}

TEST(RequirementsTest, ThrowsThemAtOnce) {
  const auto message = [](auto f) {
    try {
      f({"a", "b"}, "options");
    } catch (const CheckError& e) {
      return std::string("check ") + e.what();
    } catch (const InputError& e) {
      return std::string("input ") + e.what();
    }
    return std::string();
  };
  EXPECT_EQ(message(CheckNone), "check options: a; b");
  EXPECT_EQ(message(RejectAny), "input options: a; b");
}

}  // namespace
}  // namespace deja_view
