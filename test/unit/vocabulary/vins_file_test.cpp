#include "deja_view/base/check.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"
#include "deja_view/vocabulary/vocabulary_files.hpp"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>

#include "random_vocabulary.hpp"
#include "vocabulary_file_test.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

class VinsFileTest : public VocabularyFileTest {
 protected:
  VinsFileTest() : VocabularyFileTest("brief.bin") {}

  std::string Read(const std::filesystem::path& path) const {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  template <typename T>
  static void Put(const T& value, std::string* bytes) {
    bytes->append(reinterpret_cast<const char*>(&value), sizeof(value));
  }

  static void PutNode(
      std::int32_t id, std::int32_t parent, double weight, std::uint64_t bits, std::string* bytes) {
    Put(id, bytes);
    Put(parent, bytes);
    Put(weight, bytes);
    for (int i = 0; i < 4; ++i) {
      Put(bits + static_cast<std::uint64_t>(i), bytes);
    }
  }

  // Root with leaf 7 and inner node 3, which has leaves 9 and 2; children before parents.
  static std::string SmallFile() {
    std::string bytes;
    for (const std::int32_t field : {2, 2, 0, 0, 4, 3}) {
      Put(field, &bytes);
    }
    PutNode(9, 3, 0.1, 0xff00, &bytes);
    PutNode(7, 0, 1.5, 0, &bytes);
    PutNode(2, 3, 0.7, 0xff70, &bytes);
    PutNode(3, 0, 0.0, 0xff10, &bytes);
    for (const std::int32_t field : {7, 0, 2, 1, 9, 2}) {
      Put(field, &bytes);
    }
    return bytes;
  }
};

TEST_F(VinsFileTest, ReadsTheLayout) {
  Write(SmallFile());
  const VocabularyTree tree = ReadVinsVocabulary(path_);
  EXPECT_EQ(tree.k, 2);
  EXPECT_EQ(tree.levels, 2);
  EXPECT_EQ(tree.descriptor_name, "brief");
  ASSERT_EQ(tree.nodes.size(), 4U);
  EXPECT_EQ(tree.nodes[0].id, 9);
  EXPECT_EQ(tree.nodes[0].parent, 3);
  EXPECT_EQ(tree.nodes[0].word, 2);
  EXPECT_EQ(tree.nodes[0].weight, 0.1);
  EXPECT_EQ(tree.nodes[0].descriptor.words[3], 0xff03U);
  EXPECT_EQ(tree.nodes[1].parent, VocabularyNode::kRoot);
  EXPECT_EQ(tree.nodes[3].word, VocabularyNode::kNoWord);
  const auto vocabulary = Vocabulary::Open(path_);
  EXPECT_EQ(vocabulary->Word(tree.nodes[2].descriptor), 1U);
  EXPECT_EQ(vocabulary->Idf(1), 0.7F);
}

TEST_F(VinsFileTest, WritesTheSameBytesAgain) {
  Write(SmallFile());
  WriteVinsVocabulary(directory_ / "again.bin", ReadVinsVocabulary(path_));
  EXPECT_EQ(Read(directory_ / "again.bin"), SmallFile());
  // Also by way of our own format.
  WriteFlatVocabulary(directory_ / "flat.dvv", ReadVinsVocabulary(path_));
  WriteVinsVocabulary(directory_ / "again.bin",
                      Vocabulary::Open(directory_ / "flat.dvv")->ToTree());
  EXPECT_EQ(Read(directory_ / "again.bin"), SmallFile());
}

TEST_F(VinsFileTest, KeepsAShuffledTree) {
  VocabularyTree tree = test::RandomTree(4, 3, 1, 5);
  std::mt19937_64 rng(2);
  std::vector<std::size_t> order(tree.nodes.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), rng);
  std::vector<std::int32_t> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    place[order[i]] = static_cast<std::int32_t>(i);
  }
  VocabularyTree shuffled = tree;
  for (std::size_t i = 0; i < order.size(); ++i) {
    shuffled.nodes[i] = tree.nodes[order[i]];
    if (shuffled.nodes[i].parent != VocabularyNode::kRoot) {
      shuffled.nodes[i].parent = place[shuffled.nodes[i].parent];
    }
  }
  WriteVinsVocabulary(path_, shuffled);
  EXPECT_EQ(ReadVinsVocabulary(path_).nodes, shuffled.nodes);
  WriteFlatVocabulary(directory_ / "flat.dvv", shuffled);
  EXPECT_EQ(Vocabulary::Open(directory_ / "flat.dvv")->ToTree().nodes, shuffled.nodes);
}

TEST_F(VinsFileTest, NamesWhatIsWrong) {
  const auto with = [](std::size_t offset, std::int32_t value) {
    std::string bytes = SmallFile();
    std::memcpy(bytes.data() + offset, &value, sizeof(value));
    return bytes;
  };
  ExpectRefused(SmallFile().substr(0, 20), "header");
  ExpectRefused(SmallFile() + "x", "size");
  ExpectRefused(with(0, 1), "k:");
  ExpectRefused(with(0, 1000), "k:");
  ExpectRefused(with(4, 1), "levels:");
  ExpectRefused(with(16, -1), "nNodes");
  ExpectRefused(with(16, 0x7fffffff), "size");
  ExpectRefused(with(20, 0), "nWords");
  ExpectRefused(with(20, 5), "nWords");
  ExpectRefused(with(24, 7), "nodeId");            // twice
  ExpectRefused(with(24, 0), "nodeId");            // the root
  ExpectRefused(with(28, 77), "parentId");         // unknown
  ExpectRefused(with(28, 9), "parent");            // its own child
  ExpectRefused(with(36, -0x100000), "weight");    // not a number
  ExpectRefused(with(24 + 4 * 48, 77), "nodeId");  // of a word
  ExpectRefused(with(24 + 4 * 48, 2), "wordId");   // two words at one leaf
  ExpectRefused(with(24 + 4 * 48, 3), "word");     // at an inner node
  ExpectRefused(with(28 + 4 * 48, 1), "word");     // word 1 twice
  ExpectRefused(with(28 + 4 * 48, -3), "wordId");
}

TEST_F(VinsFileTest, SurvivesDamage) {
  const std::string sound = SmallFile();
  std::mt19937_64 rng(1);
  for (int i = 0; i < 2000; ++i) {
    std::string bytes = sound;
    bytes[rng() % bytes.size()] = static_cast<char>(rng());
    bytes[rng() % bytes.size()] = static_cast<char>(rng());
    bytes.resize(i % 5 == 0 ? rng() % bytes.size() : bytes.size());
    Write(bytes);
    try {
      Vocabulary::Open(path_);
    } catch (const InputError&) {
      continue;
    }
  }
}

}  // namespace
}  // namespace deja_view
