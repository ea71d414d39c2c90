#include "deja_view/vocabulary/vocabulary.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/vocabulary/vocabulary_files.hpp"

#include <algorithm>
#include <utility>

#include "descend.hpp"
#include "flat_format.hpp"
#include "mapped_file.hpp"

namespace deja_view {

// Either a mapped file or a buffer; the view points into it.
struct Vocabulary::Storage {
  internal::MappedFile file;
  std::vector<Descriptor> buffer;
  internal::FlatView view;
  internal::DescendFunction descend = internal::ChooseDescendKernel().descend;
  std::string descriptor_name;
};

namespace {

// A file up to this size is checked to the last byte. Beyond, hashing would take longer than
// opening may; then what keeps a descent within bounds is checked, and VerifyFlatVocabulary does
// the rest.
constexpr std::size_t kFullCheckBytes = std::size_t{16} << 20U;

}  // namespace

Vocabulary::Vocabulary(std::unique_ptr<Storage> storage) : storage_(std::move(storage)) {
  storage_->descriptor_name = storage_->view.header->descriptor_name;
}

Vocabulary::~Vocabulary() = default;

std::shared_ptr<const Vocabulary> Vocabulary::Open(const std::filesystem::path& path) {
  switch (DetectVocabularyFormat(path)) {
    case VocabularyFormat::kVins:
      return FromTree(ReadVinsVocabulary(path), path.string());
    case VocabularyFormat::kOrbSlam:
      return FromTree(ReadOrbSlamVocabulary(path), path.string());
    case VocabularyFormat::kFlat:
      break;
  }
  auto storage = std::make_unique<Storage>();
  storage->file = internal::MappedFile(path);
  const internal::FlatCheck check = storage->file.size() <= kFullCheckBytes
                                        ? internal::FlatCheck::kAll
                                        : internal::FlatCheck::kStructure;
  storage->view =
      internal::ViewFlat(storage->file.data(), storage->file.size(), path.string(), check);
  return std::shared_ptr<const Vocabulary>(new Vocabulary(std::move(storage)));
}

std::shared_ptr<const Vocabulary> Vocabulary::FromTree(const VocabularyTree& tree,
                                                       const std::string& source) {
  auto storage = std::make_unique<Storage>();
  storage->buffer = internal::BuildFlat(tree, source);
  storage->view = internal::ViewFlat(storage->buffer.data(),
                                     storage->buffer.size() * sizeof(Descriptor),
                                     source,
                                     internal::FlatCheck::kStructure);
  return std::shared_ptr<const Vocabulary>(new Vocabulary(std::move(storage)));
}

int Vocabulary::k() const {
  return storage_->view.header->k;
}

int Vocabulary::levels() const {
  return storage_->view.header->levels;
}

std::size_t Vocabulary::word_count() const {
  return storage_->view.header->word_count;
}

std::size_t Vocabulary::node_count() const {
  return storage_->view.header->node_count;
}

const std::string& Vocabulary::descriptor_name() const {
  return storage_->descriptor_name;
}

std::uint64_t Vocabulary::identity() const {
  return storage_->view.header->identity;
}

WordId Vocabulary::Word(const Descriptor& descriptor) const {
  WordId word = 0;
  storage_->descend(storage_->view, &descriptor, 1, &word);
  return word;
}

void Vocabulary::Words(const std::vector<Descriptor>& descriptors,
                       std::vector<WordId>* words) const {
  words->resize(descriptors.size());
  storage_->descend(storage_->view, descriptors.data(), descriptors.size(), words->data());
}

BowVector Vocabulary::Bag(const std::vector<Descriptor>& descriptors) const {
  std::vector<WordId> words;
  Words(descriptors, &words);
  return CountWords(std::move(words));
}

float Vocabulary::Idf(WordId word) const {
  DEJA_VIEW_CHECK_OP(word, <, word_count());
  return storage_->view.weights[word];
}

const Descriptor& Vocabulary::Centroid(WordId word) const {
  DEJA_VIEW_CHECK_OP(word, <, word_count());
  return storage_->view.descriptors[storage_->view.word_nodes[word]];
}

VocabularyTree Vocabulary::ToTree() const {
  return internal::UnbuildFlat(storage_->view);
}

BowVector CountWords(std::vector<WordId> words) {
  std::sort(words.begin(), words.end());
  BowVector bow;
  bow.descriptor_count = static_cast<std::uint32_t>(words.size());
  bow.entries.reserve(words.size());
  for (const WordId word : words) {
    if (bow.entries.empty() || bow.entries.back().word != word) {
      bow.entries.push_back({word, 1});
    } else {
      ++bow.entries.back().count;
    }
  }
  return bow;
}

}  // namespace deja_view
