#include "descend.hpp"

#include <random>
#include <string>

#include "random_vocabulary.hpp"
#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

class DescendKernels : public ::testing::TestWithParam<int> {};

TEST_P(DescendKernels, AllGiveTheSame) {
  const int k = GetParam();
  const VocabularyTree tree = test::RandomTree(k, k > 20 ? 1 : 3, 1, 5);
  const std::vector<Descriptor> bytes = BuildFlat(tree, "test");
  const FlatView view =
      ViewFlat(bytes.data(), bytes.size() * sizeof(Descriptor), "test", FlatCheck::kAll);
  std::mt19937_64 rng(2);
  std::vector<Descriptor> descriptors;
  for (int i = 0; i < 203; ++i) {
    descriptors.push_back(
        test::Disturb(tree.nodes[rng() % tree.nodes.size()].descriptor, 30, &rng));
  }
  const std::vector<DescendKernel> kernels = AvailableDescendKernels();
  const DescendKernel& portable = kernels.back();
  ASSERT_EQ(std::string(portable.name), "portable");
  std::vector<WordId> expected(descriptors.size());
  portable.descend(view, descriptors.data(), descriptors.size(), expected.data());
  std::vector<std::uint8_t> expected_labels(descriptors.size());
  portable.assign(descriptors.data(),
                  descriptors.size(),
                  view.descriptors + 1,
                  static_cast<std::uint32_t>(k),
                  expected_labels.data());
  for (const DescendKernel& kernel : kernels) {
    std::vector<WordId> words(descriptors.size());
    kernel.descend(view, descriptors.data(), descriptors.size(), words.data());
    EXPECT_EQ(words, expected) << kernel.name;
    std::vector<std::uint8_t> labels(descriptors.size());
    kernel.assign(descriptors.data(),
                  descriptors.size(),
                  view.descriptors + 1,
                  static_cast<std::uint32_t>(k),
                  labels.data());
    EXPECT_EQ(labels, expected_labels) << kernel.name;
    std::vector<std::uint16_t> distances(descriptors.size(), 120);
    kernel.lower(descriptors.data(), descriptors.size(), descriptors[0], distances.data());
    for (std::size_t i = 0; i < descriptors.size(); ++i) {
      EXPECT_EQ(distances[i], std::min(120, HammingDistance(descriptors[i], descriptors[0])));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Branching,
                         DescendKernels,
                         ::testing::Values(1, 2, 3, 7, 8, 9, 10, 15, 16, 17, 255));

}  // namespace
}  // namespace deja_view::internal
