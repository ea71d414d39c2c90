#include "deja_view/bundle/bundle_options.hpp"

#include <gmock/gmock.h>

namespace deja_view {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(BundleOptions, DefaultsAreValid) {
  EXPECT_THAT(BundleOptions().Validate(), IsEmpty());
}

TEST(BundleOptions, NameEveryViolation) {
  BundleOptions options;
  options.rounds = 0;
  options.first_error_px = 1;
  options.camera_sigmas.focal = 0;
  EXPECT_THAT(
      options.Validate(),
      ElementsAre(
          HasSubstr("rounds"), HasSubstr("first_error_px"), HasSubstr("camera_sigmas.focal")));
}

}  // namespace
}  // namespace deja_view
