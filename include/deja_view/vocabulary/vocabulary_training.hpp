#pragma once

#include "deja_view/features/types.hpp"
#include "deja_view/vocabulary/vocabulary_tree.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace deja_view {

struct TrainOptions {
  int k = 10;           ///< children of a node, 2 to 255
  int levels = 6;       ///< depth of the tree, at most; 1 to 32
  int max_words = 0;    ///< 0: as many as k and levels make; else the fullest nodes split first
  int iterations = 12;  ///< of k-means at each node, at most; it stops when nothing changes
  std::uint32_t seed = 1;
  int threads = 0;  ///< 0: all cores; the result is the same for any number
  std::string descriptor_name = "brief";

  /// Violations, one line each; empty when all is well.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("k", k);
    v("levels", levels);
    v("max_words", max_words);
    v("iterations", iterations);
    v("seed", seed);
    v("threads", threads);
    v("descriptor", descriptor_name);
  }
};

/// Called now and then, from the caller's thread, with how many nodes have been split or found
/// final, out of as many as are known so far.
using TrainProgress = std::function<void(std::size_t done, std::size_t total)>;

/// Trains a vocabulary by hierarchical k-means in Hamming space: greedy k-means++ seeding (Arthur
/// and Vassilvitskii, SODA 2007; the squared Euclidean distance of binary vectors is their Hamming
/// distance), bitwise majority as mean, a node with at most k distinct descriptors becomes their
/// parent. Weights are idf = log(images / images that show the word), `images[i]` being the
/// descriptors of one image. Deterministic in (images, options). Throws InputError when there is no
/// descriptor at all.
VocabularyTree TrainVocabulary(const std::vector<std::vector<Descriptor>>& images,
                               const TrainOptions& options,
                               const TrainProgress& progress = {});

}  // namespace deja_view
