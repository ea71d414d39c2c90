#include "deja_view/vocabulary/vocabulary.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/vocabulary/vocabulary_files.hpp"

#include <filesystem>
#include <random>

#include "random_vocabulary.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace deja_view {
namespace {

using test::Disturb;
using test::RandomDescriptor;
using test::RandomTree;

// DBoW2's greedy descent, straight from the tree.
WordId ReferenceWord(const VocabularyTree& tree, const Descriptor& descriptor) {
  std::int32_t node = VocabularyNode::kRoot;
  while (true) {
    std::int32_t nearest = -1;
    int nearest_distance = 257;
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
      if (tree.nodes[i].parent == node) {
        const int distance = HammingDistance(tree.nodes[i].descriptor, descriptor);
        if (distance < nearest_distance) {
          nearest_distance = distance;
          nearest = static_cast<std::int32_t>(i);
        }
      }
    }
    node = nearest;
    if (tree.nodes[node].word != VocabularyNode::kNoWord) {
      return static_cast<WordId>(tree.nodes[node].word);
    }
  }
}

std::vector<Descriptor> RandomDescriptors(const VocabularyTree& tree, std::size_t count) {
  std::mt19937_64 rng(11);
  std::vector<Descriptor> descriptors;
  for (std::size_t i = 0; i < count; ++i) {
    descriptors.push_back(i % 3 == 0 ? RandomDescriptor(&rng)
                                     : Disturb(tree.nodes[rng() % tree.nodes.size()].descriptor,
                                               static_cast<int>(rng() % 60),
                                               &rng));
  }
  return descriptors;
}

TEST(Vocabulary, FindsTheWordsOfAGreedyDescent) {
  const VocabularyTree tree = RandomTree(5, 4, 1, 4);  // leaves on every level
  const auto vocabulary = Vocabulary::FromTree(tree);
  for (const Descriptor& descriptor : RandomDescriptors(tree, 200)) {
    EXPECT_EQ(vocabulary->Word(descriptor), ReferenceWord(tree, descriptor));
  }
}

TEST(Vocabulary, ManyWordsAreTheSameAsOneByOne) {
  const VocabularyTree tree = RandomTree(10, 3, 2, 5);
  const auto vocabulary = Vocabulary::FromTree(tree);
  for (const std::size_t count : {0U, 1U, 15U, 16U, 17U, 100U}) {
    const std::vector<Descriptor> descriptors = RandomDescriptors(tree, count);
    std::vector<WordId> words = {99};
    vocabulary->Words(descriptors, &words);
    ASSERT_EQ(words.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(words[i], vocabulary->Word(descriptors[i]));
    }
  }
}

TEST(Vocabulary, OfEquallyNearChildrenTheFirstInTheFileIsTaken) {
  VocabularyTree tree = RandomTree(4, 1, 3);
  for (VocabularyNode& node : tree.nodes) {
    node.descriptor = Descriptor{};
    node.word = 3 - node.word;
  }
  EXPECT_EQ(Vocabulary::FromTree(tree)->Word(Descriptor{}), 3U);
  tree.nodes[0].descriptor.words[0] = 1;
  EXPECT_EQ(Vocabulary::FromTree(tree)->Word(Descriptor{}), 2U);
}

TEST(Vocabulary, BagCountsWords) {
  const VocabularyTree tree = RandomTree(4, 1, 3);
  const auto vocabulary = Vocabulary::FromTree(tree);
  const BowVector bow = vocabulary->Bag(
      {tree.nodes[2].descriptor, tree.nodes[0].descriptor, tree.nodes[2].descriptor});
  EXPECT_EQ(bow.descriptor_count, 3U);
  EXPECT_THAT(bow.entries, ::testing::ElementsAre(WordCount{0, 1}, WordCount{2, 2}));
  EXPECT_TRUE(vocabulary->Bag({}).entries.empty());
}

TEST(Vocabulary, TellsWhatItHolds) {
  VocabularyTree tree = RandomTree(3, 2, 4);
  tree.descriptor_name = "orb";
  const auto vocabulary = Vocabulary::FromTree(tree);
  EXPECT_EQ(vocabulary->k(), 3);
  EXPECT_EQ(vocabulary->levels(), 2);
  EXPECT_EQ(vocabulary->word_count(), 9U);
  EXPECT_EQ(vocabulary->node_count(), 12U);
  EXPECT_EQ(vocabulary->descriptor_name(), "orb");
  for (const VocabularyNode& node : tree.nodes) {
    if (node.word != VocabularyNode::kNoWord) {
      EXPECT_EQ(vocabulary->Centroid(static_cast<WordId>(node.word)), node.descriptor);
      EXPECT_EQ(vocabulary->Idf(static_cast<WordId>(node.word)), static_cast<float>(node.weight));
    }
  }
  EXPECT_THROW(vocabulary->Idf(9), CheckError);
  EXPECT_THROW(vocabulary->Centroid(9), CheckError);
}

TEST(Vocabulary, IdentityDependsOnContentNotOnTheOrderOfRecords) {
  const VocabularyTree tree = RandomTree(3, 2, 4);
  const std::uint64_t identity = Vocabulary::FromTree(tree)->identity();
  VocabularyTree other = tree;
  other.nodes[7].descriptor.words[2] ^= 1U;
  EXPECT_NE(Vocabulary::FromTree(other)->identity(), identity);
  other = tree;
  other.nodes[7].weight += 0.5;
  EXPECT_NE(Vocabulary::FromTree(other)->identity(), identity);
  other = tree;
  other.descriptor_name = "orb";
  EXPECT_NE(Vocabulary::FromTree(other)->identity(), identity);
  other = tree;
  for (VocabularyNode& node : other.nodes) {
    node.id += 100;
  }
  EXPECT_EQ(Vocabulary::FromTree(other)->identity(), identity);
}

TEST(Vocabulary, OpensEveryFormatAndIsTheSame) {
  const auto directory = std::filesystem::path(::testing::TempDir()) /
                         ("deja_view_vocabulary_test" + std::to_string(::getpid()));
  const VocabularyTree tree = RandomTree(4, 3, 5, 6);
  const auto vocabulary = Vocabulary::FromTree(tree);
  const std::vector<Descriptor> descriptors = RandomDescriptors(tree, 50);
  for (const char* name : {"v.dvv", "v.bin"}) {
    WriteVocabulary(directory / name, tree);
    const auto opened = Vocabulary::Open(directory / name);
    EXPECT_EQ(opened->identity(), vocabulary->identity()) << name;
    EXPECT_EQ(opened->Bag(descriptors).entries, vocabulary->Bag(descriptors).entries) << name;
  }
  // ORB-SLAM's format is for another descriptor.
  WriteVocabulary(directory / "v.txt", tree);
  const auto text = Vocabulary::Open(directory / "v.txt");
  EXPECT_EQ(text->descriptor_name(), "orb");
  EXPECT_EQ(text->Bag(descriptors).entries, vocabulary->Bag(descriptors).entries);
  std::filesystem::remove_all(directory);
}

TEST(Vocabulary, ComesBackAsATree) {
  const VocabularyTree tree = RandomTree(4, 3, 5, 6);
  const VocabularyTree back = Vocabulary::FromTree(tree)->ToTree();
  EXPECT_EQ(back.k, tree.k);
  EXPECT_EQ(back.levels, tree.levels);
  EXPECT_EQ(back.descriptor_name, tree.descriptor_name);
  EXPECT_EQ(back.nodes, tree.nodes);
}

struct BrokenTree {
  const char* field;  // that the message must name
  void (*breaks)(VocabularyTree*);
};

std::vector<BrokenTree> BrokenTrees() {
  return {BrokenTree{"k:", [](VocabularyTree* t) { t->k = 2; }},
          BrokenTree{"k:", [](VocabularyTree* t) { t->k = 256; }},
          BrokenTree{"levels:", [](VocabularyTree* t) { t->levels = 1; }},
          BrokenTree{"levels:", [](VocabularyTree* t) { t->levels = 0; }},
          BrokenTree{"nodes:", [](VocabularyTree* t) { t->nodes.clear(); }},
          BrokenTree{"descriptor_name:", [](VocabularyTree* t) { t->descriptor_name = "sift"; }},
          BrokenTree{"parent:", [](VocabularyTree* t) { t->nodes[5].parent = 100; }},
          BrokenTree{"parent:", [](VocabularyTree* t) { t->nodes[5].parent = -2; }},
          BrokenTree{"parent:", [](VocabularyTree* t) { t->nodes[0].parent = 3; }},
          BrokenTree{"word:", [](VocabularyTree* t) { t->nodes[0].word = 4; }},
          BrokenTree{"word:", [](VocabularyTree* t) { t->nodes[5].word = 4; }},
          BrokenTree{"word:", [](VocabularyTree* t) { t->nodes[5].word = 9; }},
          BrokenTree{"word:", [](VocabularyTree* t) { t->nodes[5].word = -1; }},
          BrokenTree{"weight:", [](VocabularyTree* t) { t->nodes[5].weight = -1; }},
          BrokenTree{"weight:", [](VocabularyTree* t) { t->nodes[5].weight = std::nan(""); }}};
}

class VocabularyBrokenTree : public ::testing::TestWithParam<BrokenTree> {};

TEST_P(VocabularyBrokenTree, IsRefusedWithTheFieldsName) {
  VocabularyTree tree = RandomTree(3, 2, 4);
  GetParam().breaks(&tree);
  try {
    Vocabulary::FromTree(tree, "tree.bin");
    FAIL() << "accepted";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), ::testing::StartsWith("tree.bin: "));
    EXPECT_THAT(e.what(), ::testing::HasSubstr(GetParam().field));
  }
}

INSTANTIATE_TEST_SUITE_P(All, VocabularyBrokenTree, ::testing::ValuesIn(BrokenTrees()));

TEST(CountWords, SortsAndCounts) {
  const BowVector bow = CountWords({5, 1, 5, 5, 2});
  EXPECT_THAT(bow.entries,
              ::testing::ElementsAre(WordCount{1, 1}, WordCount{2, 1}, WordCount{5, 3}));
  EXPECT_EQ(bow.descriptor_count, 5U);
}

}  // namespace
}  // namespace deja_view
