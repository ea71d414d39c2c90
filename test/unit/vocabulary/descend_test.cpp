#include "descend.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include "instruction_sets.hpp"
#include "random_vocabulary.hpp"
#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

struct Results {
  std::vector<WordId> words;
  std::vector<std::uint8_t> labels;
};

Results Run(const DescendKernel& kernel,
            const FlatView& view,
            const std::vector<Descriptor>& descriptors,
            int k) {
  Results results;
  results.words.resize(descriptors.size());
  kernel.descend(view, descriptors.data(), descriptors.size(), results.words.data());
  results.labels.resize(descriptors.size());
  kernel.assign(descriptors.data(),
                descriptors.size(),
                view.descriptors + 1,
                static_cast<std::uint32_t>(k),
                results.labels.data());
  return results;
}

void ExpectAgreement(int k) {
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
  const DescendKernel kernel = ChooseDescendKernel();
  const Results results = Run(kernel, view, descriptors, k);
  const Results expected = Run(PortableDescendKernel(), view, descriptors, k);
  EXPECT_EQ(results.words, expected.words);
  EXPECT_EQ(results.labels, expected.labels);
  std::vector<std::uint16_t> distances(descriptors.size(), 120);
  kernel.lower(descriptors.data(), descriptors.size(), descriptors[0], distances.data());
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    EXPECT_EQ(distances[i], std::min(120, HammingDistance(descriptors[i], descriptors[0])));
  }
}

// All centres but the first are equally near, so that the second is taken.
void ExpectTheFirstOfEqual(int k) {
  const Descriptor descriptor;
  std::vector<Descriptor> centres(static_cast<std::size_t>(k));
  centres[0].words = {~0ULL, ~0ULL, ~0ULL, ~0ULL};
  std::uint8_t label = 0;
  ChooseDescendKernel().assign(
      &descriptor, 1, centres.data(), static_cast<std::uint32_t>(k), &label);
  EXPECT_EQ(label, k > 1 ? 1 : 0);
}

class Descend : public ::testing::TestWithParam<int> {};

TEST_P(Descend, AgreesWithThePlainLoopOnEveryInstructionSet) {
  test::OnEveryInstructionSet([] {
    ExpectAgreement(GetParam());
    ExpectTheFirstOfEqual(GetParam());
  });
}

INSTANTIATE_TEST_SUITE_P(Branching,
                         Descend,
                         ::testing::Values(1, 2, 3, 7, 8, 9, 10, 15, 16, 17, 255));

}  // namespace
}  // namespace deja_view::internal
