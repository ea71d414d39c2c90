#pragma once

#include "deja_view/features/types.hpp"
#include "deja_view/vocabulary/bow_vector.hpp"
#include "deja_view/vocabulary/vocabulary_tree.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace deja_view {

/// A k-ary tree of 256-bit words (Galvez-Lopez and Tardos, "Bags of Binary Words", T-RO 2012): a
/// descriptor descends to the nearest child until a leaf, its word, is reached; of equally near
/// children the first is taken, so that words are the same as DBoW2's.
///
/// Immutable: hand it around as shared_ptr<const Vocabulary>, use it from any number of threads.
class Vocabulary {
 public:
  /// Opens a vocabulary file of any of the formats, told apart by content: our flat one (mapped
  /// into memory, not copied), VINS-Mono's brief_k10L6.bin, ORB-SLAM's ORBvoc.txt. Throws
  /// InputError that names the path and the field when the file can't be read or is not a sound
  /// vocabulary.
  static std::shared_ptr<const Vocabulary> Open(const std::filesystem::path& path);

  /// From a tree in memory. Throws InputError, naming `source` and the field, when the tree is not
  /// sound: a node without a way to the root, a leaf without a word or a word at an inner node,
  /// words that are not 0 to n-1, more than 255 children or 32 levels, weights that are not finite
  /// or negative.
  static std::shared_ptr<const Vocabulary> FromTree(const VocabularyTree& tree,
                                                    const std::string& source = "vocabulary");

  ~Vocabulary();
  Vocabulary(const Vocabulary&) = delete;
  Vocabulary& operator=(const Vocabulary&) = delete;

  int k() const;       ///< largest number of children
  int levels() const;  ///< largest depth of a leaf
  std::size_t word_count() const;
  std::size_t node_count() const;              ///< inner nodes and leaves, without the root
  const std::string& descriptor_name() const;  ///< "brief" or "orb"

  /// Hash of everything that words and weights depend on, the same whichever format it was read
  /// from; a saved map keeps it to recognise its vocabulary.
  std::uint64_t identity() const;

  /// The word of one descriptor.
  WordId Word(const Descriptor& descriptor) const;

  /// The words of many descriptors: same result as Word, faster. `words` is resized.
  void Words(const std::vector<Descriptor>& descriptors, std::vector<WordId>* words) const;

  /// Counts of the words of one image.
  BowVector Bag(const std::vector<Descriptor>& descriptors) const;

  /// Inverse document frequency of a word in the training images: log(images / images with the
  /// word).
  float Idf(WordId word) const;

  /// The word's own descriptor.
  const Descriptor& Centroid(WordId word) const;

  /// Back to the form in which files are written.
  VocabularyTree ToTree() const;

 private:
  struct Storage;
  explicit Vocabulary(std::unique_ptr<Storage> storage);

  std::unique_ptr<Storage> storage_;
};

/// Counts how often each word occurs; `words` in any order.
BowVector CountWords(std::vector<WordId> words);

}  // namespace deja_view
