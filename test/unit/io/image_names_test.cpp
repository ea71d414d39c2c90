#include "deja_view/io/image_names.hpp"

#include <gtest/gtest.h>

namespace deja_view {
namespace {

TEST(ParseImageStamp, ReadsNanosecondsAndSeconds) {
  EXPECT_EQ(ParseImageStamp("1403636625838560104.png"), 1403636625838560104);
  EXPECT_EQ(ParseImageStamp("cam0/data/1403636625838560104.jpg"), 1403636625838560104);
  EXPECT_EQ(ParseImageStamp("1403636625.838560104.png"), 1403636625838560104);
  EXPECT_EQ(ParseImageStamp("12.5.png"), 12500000000);
}

TEST(ParseImageStamp, RefusesOtherNames) {
  for (const char* name : {"frame-000001.png",
                           "-5.png",
                           "5x.png",
                           ".png",
                           "",
                           "1e9.png",
                           "1.2.3.png",
                           "99999999999999999999.png"}) {
    EXPECT_FALSE(ParseImageStamp(name).has_value()) << name;
  }
}

}  // namespace
}  // namespace deja_view
