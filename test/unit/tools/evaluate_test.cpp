#include "evaluate/evaluate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> NamesOf(const std::vector<Variant>& variants) {
  std::vector<std::string> names;
  for (const Variant& variant : variants) {
    names.push_back(variant.name);
  }
  return names;
}

std::vector<std::string> ArgumentsOf(const std::vector<Variant>& variants,
                                     const std::string& name) {
  for (const Variant& variant : variants) {
    if (variant.name == name) {
      return variant.arguments;
    }
  }
  return {"no such variant"};
}

TEST(MakeVariants, OfABagWithoutViews) {
  EXPECT_THAT(NamesOf(MakeVariants({}, false)),
              ElementsAre("no_virtual",
                          "weights_tfidf",
                          "weights_printed",
                          "weights_text",
                          "weights_synonym",
                          "threshold_sum",
                          "threshold_pair"));
}

TEST(MakeVariants, OfABagWithViews) {
  const std::vector<Variant> variants = MakeVariants({}, true);
  EXPECT_EQ(variants.size(), 9U);
  EXPECT_THAT(ArgumentsOf(variants, "no_virtual"), ElementsAre("--virtual", "off"));
  EXPECT_THAT(ArgumentsOf(variants, "virtual"), ElementsAre());
  EXPECT_THAT(ArgumentsOf(variants, "virtual_best1"), ElementsAre("--set", "views.keep=1"));
}

TEST(MakeVariants, OfEachSpacingWithViewsAndWithout) {
  EvaluateRequest request;
  request.spacings_m = {0.5};
  EXPECT_EQ(MakeVariants(request, false).size(), 8U) << "no views: none with them";
  request.virtual_bags = {{"wide", "wide.bag"}, {"paper", "paper.bag"}};
  const std::vector<Variant> variants = MakeVariants(request, false);
  EXPECT_EQ(variants.size(), 11U);
  EXPECT_THAT(ArgumentsOf(variants, "virtual_paper"), ElementsAre("--virtual-bag", "paper.bag"));
  EXPECT_THAT(ArgumentsOf(variants, "spacing_0.5_no_virtual"),
              ElementsAre("--map-spacing", "0.5", "--virtual", "off"));
  EXPECT_THAT(ArgumentsOf(variants, "spacing_0.5_virtual"),
              ElementsAre("--map-spacing", "0.5", "--virtual-bag", "wide.bag"));
}

TEST(MakeVariants, AddsWhatTheUserWantsAndOnlyThat) {
  EvaluateRequest request;
  request.extra = {{"strict", "--set  verifier.min_inliers=40"}};
  request.only = {"strict", "threshold_sum"};
  const std::vector<Variant> variants = MakeVariants(request, true);
  EXPECT_THAT(NamesOf(variants), ElementsAre("threshold_sum", "strict"));
  EXPECT_THAT(variants[1].arguments, ElementsAre("--set", "verifier.min_inliers=40"));
  request.only = {"unknown"};
  EXPECT_TRUE(MakeVariants(request, true).empty());
}

}  // namespace
}  // namespace deja_view
