// Vocabularies of all formats: whatever a file holds, the outcome is a sound vocabulary or an
// InputError; after a first byte of 1 with the hashes of what it holds.
#include "deja_view/base/hash.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"
#include "deja_view/vocabulary/vocabulary_files.hpp"

#include <cstddef>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "flat_format.hpp"
#include "fuzz.hpp"
#include "random_vocabulary.hpp"

namespace deja_view {
namespace {

namespace fs = std::filesystem;

// What a sound vocabulary must be able to do.
void Use(const Vocabulary& vocabulary) {
  std::mt19937_64 rng(1);
  std::vector<Descriptor> descriptors(40);
  for (Descriptor& descriptor : descriptors) {
    descriptor = test::RandomDescriptor(&rng);
  }
  for (const WordCount& entry : vocabulary.Bag(descriptors).entries) {
    vocabulary.Idf(entry.word);
    vocabulary.Centroid(entry.word);
  }
  Vocabulary::FromTree(vocabulary.ToTree());
}

// Hashes as a faulty writer would make them, so that damage gets past them.
void Rehash(std::string* bytes) {
  using internal::FlatHeader;
  if (bytes->size() < sizeof(FlatHeader)) {
    return;
  }
  FlatHeader header;
  std::memcpy(&header, bytes->data(), sizeof(header));
  for (internal::FlatSection& section : header.sections) {
    if (section.offset <= bytes->size() && section.size <= bytes->size() - section.offset) {
      section.hash = Hash64(bytes->data() + section.offset, section.size);
    }
  }
  header.header_hash = Hash64(&header, offsetof(FlatHeader, header_hash));
  std::memcpy(bytes->data(), &header, sizeof(header));
}

}  // namespace

namespace fuzz {

std::vector<std::string> Seeds() {
  std::vector<std::string> seeds;
  for (const char* extension : {".dvv", ".bin", ".txt"}) {
    const fs::path path = Scratch() / (std::string("seed") + extension);
    VocabularyTree tree = test::RandomTree(3, 3, 1, 4);
    tree.nodes[1].id = 1000;
    WriteVocabulary(path, tree);
    seeds.push_back('\0' + ReadAll(path));
    if (path.extension() == ".dvv") {
      seeds.push_back('\1' + ReadAll(path));  // the others have no hashes
    }
  }
  return seeds;
}

void RunOne(const std::string& input) {
  auto [prefix, bytes] = SplitPrefix(input);
  if (prefix == 1) {
    Rehash(&bytes);
  }
  Use(*Vocabulary::Open(Write("vocabulary", bytes)));
}

}  // namespace fuzz
}  // namespace deja_view
