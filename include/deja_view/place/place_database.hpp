#pragma once

#include "deja_view/place/place_match.hpp"
#include "deja_view/vocabulary/bow_vector.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace deja_view {

/// How places are compared.
struct PlaceDatabaseOptions {
  /// "l1": 1 - 1/2 |a/|a| - b/|b||_1; "cosine": a.b / (|a||b|). Both in [0, 1].
  std::string score = "l1";
  /// Where a word's idf comes from (see TfIdf): "frozen", the images that the vocabulary was
  /// trained from, or "running", the database's own content at the time of the query.
  std::string idf = "frozen";

  /// Violations, one line each; empty when all is well.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("score", score);
    v("idf", idf);
  }
};

/// Inverted index from words to the places (keyframes) that show them.
///
/// An entry is known by (id, tag): id is the keyframe's index, tag tells several entries of one
/// keyframe apart (0 for its real image). Exact: Query returns what Score against every entry
/// would. Const methods may be called from several threads.
class PlaceDatabase {
 public:
  /// Throws CheckError for invalid options.
  PlaceDatabase(const PlaceDatabaseOptions& options, std::shared_ptr<const Vocabulary> vocabulary);
  ~PlaceDatabase();
  PlaceDatabase(PlaceDatabase&& other) noexcept;
  PlaceDatabase& operator=(PlaceDatabase&& other) noexcept;

  /// Adds an entry; (id, tag) must be new, its words in the vocabulary, sorted, each once.
  void Add(int id, const BowVector& bow, int tag = 0);

  /// Removes all entries of `id`; false when there is none.
  bool Remove(int id);

  /// Removes one entry; false when there is none.
  bool Remove(int id, int tag);

  /// The best entries, best first; of equal scores the lowest (id, tag) first.
  std::vector<PlaceMatch> Query(const BowVector& bow, const PlaceQuery& query) const;

  /// Score of two images with the weights of this moment; bit for bit what Query computes when `b`
  /// is an entry and `a` the query. 0 when one of them has no weight at all.
  double Score(const BowVector& a, const BowVector& b) const;

  std::size_t size() const;          ///< entries
  std::size_t memory_bytes() const;  ///< heap memory of the index, with its reserves

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deja_view
