// Feeds arbitrary bytes to the vocabulary readers: whatever they hold, the outcome is a sound
// vocabulary or an InputError. The first byte chooses the format, the rest is the file.
//
// With Clang, -DDEJA_VIEW_FUZZ=ON links libFuzzer. Otherwise this is a program that runs over the
// files given, or, without any, over damaged copies of small vocabularies of each format from a
// fixed seed.

#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"
#include "deja_view/vocabulary/vocabulary_files.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "flat_format.hpp"
#include "random_vocabulary.hpp"
#include <unistd.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

fs::path TemporaryFile() {
  return fs::temp_directory_path() / ("deja_view_vocabulary_fuzz" + std::to_string(::getpid()));
}

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

void RunOne(const std::uint8_t* data, std::size_t size) {
  if (size == 0) {
    return;
  }
  std::string bytes(data + 1, data + size);
  if (data[0] % 2 == 1) {
    Rehash(&bytes);
  }
  const fs::path path = TemporaryFile();
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
  try {
    Use(*Vocabulary::Open(path));
  } catch (const InputError&) {  // the other allowed outcome
  }
  fs::remove(path);
}

}  // namespace
}  // namespace deja_view

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  deja_view::RunOne(data, size);
  return 0;
}

#ifndef DEJA_VIEW_LIBFUZZER
namespace {

std::string ReadAll(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void RunDamaged(int rounds) {
  using namespace deja_view;  // NOLINT(google-build-using-namespace): a few lines
  std::mt19937_64 rng(1);
  for (const char* extension : {".dvv", ".bin", ".txt"}) {
    const std::filesystem::path path = TemporaryFile().string() + extension;
    VocabularyTree tree = test::RandomTree(3, 3, 1, 4);
    tree.nodes[1].id = 1000;
    WriteVocabulary(path, tree);
    const std::string sound = ReadAll(path);
    std::filesystem::remove(path);
    for (int round = 0; round < rounds; ++round) {
      std::string bytes = sound;
      for (std::uint64_t flips = rng() % 5; flips > 0; --flips) {
        bytes[rng() % bytes.size()] = static_cast<char>(rng());
      }
      if (rng() % 8 == 0) {
        bytes.resize(rng() % bytes.size());
      }
      bytes.insert(bytes.begin(), static_cast<char>(round));
      RunOne(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string bytes = ReadAll(argv[i]);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }
  if (argc == 1) {
    RunDamaged(500);
  }
  std::cout << "no crash\n";
  return 0;
}
#endif
