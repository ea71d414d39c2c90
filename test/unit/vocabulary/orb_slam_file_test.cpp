#include "deja_view/base/check.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"
#include "deja_view/vocabulary/vocabulary_files.hpp"

#include <filesystem>
#include <fstream>

#include "random_vocabulary.hpp"
#include "vocabulary_file_test.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

class OrbSlamFileTest : public VocabularyFileTest {
 protected:
  OrbSlamFileTest() : VocabularyFileTest("ORBvoc.txt") {}

  // A node's line; every byte of the descriptor is `byte`.
  static std::string Line(int parent, int is_leaf, int byte, const std::string& weight) {
    std::string line = std::to_string(parent) + " " + std::to_string(is_leaf) + " ";
    for (int i = 0; i < 32; ++i) {
      line += std::to_string(byte) + " ";
    }
    return line + " " + weight + "\n";
  }

  static std::string SmallFile() {
    return "10 6  0 0\n" + Line(0, 0, 0, "0") + Line(0, 1, 255, "7.25") + Line(1, 1, 1, "0.5") +
           Line(1, 1, 128, "1e-2");
  }
};

TEST_F(OrbSlamFileTest, ReadsTheLayout) {
  Write(SmallFile());
  const VocabularyTree tree = ReadOrbSlamVocabulary(path_);
  EXPECT_EQ(tree.k, 10);
  EXPECT_EQ(tree.levels, 6);
  EXPECT_EQ(tree.descriptor_name, "orb");
  ASSERT_EQ(tree.nodes.size(), 4U);
  EXPECT_EQ(tree.nodes[0].parent, VocabularyNode::kRoot);
  EXPECT_EQ(tree.nodes[0].word, VocabularyNode::kNoWord);
  EXPECT_EQ(tree.nodes[1].word, 0);
  EXPECT_EQ(tree.nodes[1].weight, 7.25);
  EXPECT_EQ(tree.nodes[2].parent, 0);
  EXPECT_EQ(tree.nodes[2].word, 1);
  EXPECT_EQ(tree.nodes[3].descriptor.words[2], 0x8080808080808080U);
  EXPECT_EQ(tree.nodes[3].weight, 0.01);
}

TEST_F(OrbSlamFileTest, TakesWindowsLineEndsAndNoLastOne) {
  std::string text = SmallFile();
  text.pop_back();
  const VocabularyTree plain = (Write(SmallFile()), ReadOrbSlamVocabulary(path_));
  std::string windows;
  for (const char c : text) {
    windows += c == '\n' ? "\r\n" : std::string(1, c);
  }
  Write(windows);
  EXPECT_EQ(ReadOrbSlamVocabulary(path_).nodes, plain.nodes);
}

TEST_F(OrbSlamFileTest, ReadsWhatItWrites) {
  VocabularyTree tree = test::RandomTree(4, 3, 1, 5);
  tree.descriptor_name = "orb";
  WriteOrbSlamVocabulary(path_, tree);
  EXPECT_EQ(ReadOrbSlamVocabulary(path_).nodes, tree.nodes);
}

TEST_F(OrbSlamFileTest, WritesParentsFirst) {
  VocabularyTree tree = test::RandomTree(3, 2, 1);
  tree.descriptor_name = "orb";
  std::reverse(tree.nodes.begin(), tree.nodes.end());
  const auto last = static_cast<std::int32_t>(tree.nodes.size()) - 1;
  for (VocabularyNode& node : tree.nodes) {
    node.parent = node.parent == VocabularyNode::kRoot ? node.parent : last - node.parent;
  }
  WriteOrbSlamVocabulary(path_, tree);
  const VocabularyTree back = ReadOrbSlamVocabulary(path_);
  for (std::size_t i = 0; i < back.nodes.size(); ++i) {
    EXPECT_LT(back.nodes[i].parent, static_cast<std::int64_t>(i));
  }
  // Words have other numbers, but the same descriptors.
  const auto before = Vocabulary::FromTree(tree);
  const auto after = Vocabulary::Open(path_);
  std::mt19937_64 rng(1);
  for (int i = 0; i < 50; ++i) {
    const Descriptor descriptor = test::RandomDescriptor(&rng);
    EXPECT_EQ(before->Centroid(before->Word(descriptor)), after->Centroid(after->Word(descriptor)));
  }
}

TEST_F(OrbSlamFileTest, NamesLineAndField) {
  ExpectRefused("10 6 0\n" + Line(0, 1, 0, "0"), "line 1: weighting");
  ExpectRefused("10 99 0 0\n" + Line(0, 1, 0, "0"), "line 1: L");
  ExpectRefused("10 6 0 0\n", "no node");
  ExpectRefused(SmallFile() + Line(0, 2, 0, "1"), "line 6: isLeaf");
  ExpectRefused(SmallFile() + Line(0, 1, 256, "1"), "line 6: descriptor");
  ExpectRefused(SmallFile() + Line(0, 1, 0, ""), "line 6: weight");
  ExpectRefused(SmallFile() + Line(0, 1, 0, "one"), "line 6: weight");
  ExpectRefused(SmallFile() + Line(0, 1, 0, "nan"), "weight");
  ExpectRefused(SmallFile() + Line(0, 1, 0, "1 2"), "line 6: '2'");
  ExpectRefused(SmallFile() + Line(-1, 1, 0, "1"), "line 6: parentId");
  ExpectRefused(SmallFile() + Line(99, 1, 0, "1"), "parent");
  ExpectRefused(SmallFile() + Line(2, 1, 0, "1"), "word");  // child of a leaf
  ExpectRefused(SmallFile() + Line(0, 0, 0, "1"), "word");  // inner node without children
  ExpectRefused(SmallFile() + std::string(5000, '1'), "line 6: parentId");
}

}  // namespace
}  // namespace deja_view
