#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"

#include <cstring>
#include <random>
#include <string>

#include "flat_format.hpp"
#include "random_vocabulary.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view::internal {
namespace {

class FlatViewTest : public ::testing::Test {
 protected:
  FlatViewTest() {
    VocabularyTree tree = test::RandomTree(4, 3, 1, 5);
    tree.nodes[3].id = 1000;  // so that there are sources
    bytes_ = BuildFlat(tree, "test");
  }

  std::size_t size() const { return bytes_.size() * sizeof(Descriptor); }
  char* data() { return reinterpret_cast<char*>(bytes_.data()); }
  FlatHeader* header() { return reinterpret_cast<FlatHeader*>(bytes_.data()); }
  template <typename T>
  T* Section(SectionId id) {
    return reinterpret_cast<T*>(data() + header()->sections[id].offset);
  }

  // Hashes as a faulty writer would make them: only the checks of the content are left.
  void Rehash() {
    for (FlatSection& section : header()->sections) {
      if (section.offset <= size() && section.size <= size() - section.offset) {
        section.hash = Hash64(data() + section.offset, section.size);
      }
    }
    header()->header_hash = Hash64(header(), offsetof(FlatHeader, header_hash));
  }

  void ExpectRefused(const std::string& field) {
    try {
      ViewFlat(bytes_.data(), size(), "some.dvv", FlatCheck::kAll);
      ADD_FAILURE() << "accepted, expected: " << field;
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), ::testing::StartsWith("some.dvv: "));
      EXPECT_THAT(e.what(), ::testing::HasSubstr(field));
    }
  }

  std::vector<Descriptor> bytes_;
};

TEST_F(FlatViewTest, AcceptsWhatWasBuilt) {
  const FlatView view = ViewFlat(bytes_.data(), size(), "some.dvv", FlatCheck::kAll);
  EXPECT_NE(view.sources, nullptr);
  Rehash();
  EXPECT_NO_THROW(ViewFlat(bytes_.data(), size(), "some.dvv", FlatCheck::kAll));
}

TEST_F(FlatViewTest, NoticesEveryFlippedByte) {
  // Bytes between the sections belong to nothing.
  std::vector<bool> is_covered(size(), false);
  std::fill_n(is_covered.begin(), sizeof(FlatHeader), true);
  for (const FlatSection& section : header()->sections) {
    std::fill_n(
        is_covered.begin() + static_cast<std::ptrdiff_t>(section.offset), section.size, true);
  }
  for (std::size_t i = 0; i < size(); ++i) {
    if (is_covered[i]) {
      data()[i] ^= static_cast<char>(1 << (i % 8));
      EXPECT_THROW(ViewFlat(bytes_.data(), size(), "some.dvv", FlatCheck::kAll), InputError) << i;
      data()[i] ^= static_cast<char>(1 << (i % 8));
    }
  }
}

TEST_F(FlatViewTest, NoticesEveryTruncation) {
  for (std::size_t length = 0; length < size(); ++length) {
    EXPECT_THROW(ViewFlat(bytes_.data(), length, "some.dvv", FlatCheck::kStructure), InputError);
  }
}

TEST_F(FlatViewTest, NamesTheFieldThatIsWrong) {
  const std::vector<Descriptor> sound = bytes_;
  const auto with = [&](const char* field, auto change) {
    bytes_ = sound;
    change();
    Rehash();
    ExpectRefused(field);
  };
  with("magic", [&] { header()->magic[0] = 'X'; });
  with("version", [&] { header()->version = 2; });
  with("header_size", [&] { header()->header_size = 0; });
  with("file_size", [&] { header()->file_size += 64; });
  with("descriptor_name", [&] { std::memset(header()->descriptor_name, 'x', 16); });
  with("k:", [&] { header()->k = 0; });
  with("levels:", [&] { header()->levels = 33; });
  with("node_count", [&] { header()->node_count = std::uint64_t{1} << 60U; });
  with("word_count", [&] { header()->word_count = header()->node_count + 1; });
  with("links.size", [&] { header()->sections[kLinks].size -= 8; });
  with("weights.offset", [&] { header()->sections[kWeights].offset += 4; });
  with("descriptors.offset", [&] { header()->sections[kDescriptors].offset = ~63ULL; });
  with("links", [&] { Section<NodeLink>(kLinks)[0].first = 0; });
  with("links", [&] { Section<NodeLink>(kLinks)[1].count = 200; });
  with("links", [&] { Section<NodeLink>(kLinks)[size() / 200].first = 0x7fffffff; });
  with("weights", [&] { Section<float>(kWeights)[1] = -1; });
  with("links", [&] { Section<std::uint32_t>(kWordNodes)[1] = 0; });
  with("sources", [&] { Section<NodeSource>(kSources)[2].record = -1; });
  with("sources",
       [&] { Section<NodeSource>(kSources)[2].record = Section<NodeSource>(kSources)[1].record; });
}

TEST_F(FlatViewTest, SurvivesDamageBehindGoodHashes) {
  const std::vector<Descriptor> sound = bytes_;
  std::mt19937_64 rng(1);
  for (int i = 0; i < 3000; ++i) {
    bytes_ = sound;
    for (int flips = 0; flips < 3; ++flips) {
      data()[rng() % size()] = static_cast<char>(rng());
    }
    Rehash();
    try {
      const FlatView view = ViewFlat(bytes_.data(), size(), "some.dvv", FlatCheck::kAll);
      UnbuildFlat(view);
    } catch (const InputError&) {
      continue;
    }
  }
}

}  // namespace
}  // namespace deja_view::internal
