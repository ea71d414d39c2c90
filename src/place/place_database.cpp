#include "deja_view/place/place_database.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "similarity.hpp"

namespace deja_view {

std::vector<std::string> PlaceDatabaseOptions::Validate() const {
  std::vector<std::string> violations;
  if (score != "l1" && score != "cosine") {
    violations.push_back(fmt::format("score: is '{}', expected l1 or cosine", score));
  }
  if (idf != "frozen" && idf != "running") {
    violations.push_back(fmt::format("idf: is '{}', expected frozen or running", idf));
  }
  return violations;
}

class PlaceDatabase::Impl {
 public:
  Impl(const PlaceDatabaseOptions& options, std::shared_ptr<const Vocabulary> vocabulary)
      : weights(options.idf == "running" ? IdfMode::kRunning : IdfMode::kFrozen, *vocabulary),
        score(options.score == "cosine" ? ScoreKind::kCosine : ScoreKind::kL1) {}

  struct Entry {
    int id;
    int tag;
    BowVector bow;
  };

  internal::WordWeights weights;
  internal::ScoreKind score;
  std::vector<Entry> entries;

 private:
  using IdfMode = internal::IdfMode;
  using ScoreKind = internal::ScoreKind;
};

PlaceDatabase::PlaceDatabase(const PlaceDatabaseOptions& options,
                             std::shared_ptr<const Vocabulary> vocabulary) {
  const std::vector<std::string> violations = options.Validate();
  if (!violations.empty()) {
    throw CheckError(fmt::format("place database: {}", fmt::join(violations, "; ")));
  }
  impl_ = std::make_unique<Impl>(options, std::move(vocabulary));
}

PlaceDatabase::~PlaceDatabase() = default;
PlaceDatabase::PlaceDatabase(PlaceDatabase&&) noexcept = default;
PlaceDatabase& PlaceDatabase::operator=(PlaceDatabase&&) noexcept = default;

void PlaceDatabase::Add(int id, const BowVector& bow, int tag) {
  impl_->weights.Add(bow);
  impl_->entries.push_back({id, tag, bow});
}

bool PlaceDatabase::Remove(int id) {
  auto& entries = impl_->entries;
  const auto removed = std::stable_partition(
      entries.begin(), entries.end(), [id](const Impl::Entry& entry) { return entry.id != id; });
  const bool any = removed != entries.end();
  for (auto entry = removed; entry != entries.end(); ++entry) {
    impl_->weights.Remove(entry->bow);
  }
  entries.erase(removed, entries.end());
  return any;
}

std::vector<PlaceMatch> PlaceDatabase::Query(const BowVector& bow, const PlaceQuery& query) const {
  std::vector<PlaceMatch> matches;
  for (const Impl::Entry& entry : impl_->entries) {
    const double score = Score(bow, entry.bow);
    if (entry.id >= query.min_id && entry.id <= query.max_id && score > 0 &&
        score >= query.min_score) {
      matches.push_back({entry.id, entry.tag, score});
    }
  }
  std::sort(matches.begin(), matches.end(), [](const PlaceMatch& a, const PlaceMatch& b) {
    return std::make_tuple(-a.score, a.id, a.tag) < std::make_tuple(-b.score, b.id, b.tag);
  });
  matches.resize(
      std::min(matches.size(), static_cast<std::size_t>(std::max(0, query.max_results))));
  return matches;
}

double PlaceDatabase::Score(const BowVector& a, const BowVector& b) const {
  return internal::Similarity(impl_->score, impl_->weights, a, b);
}

std::size_t PlaceDatabase::size() const {
  return impl_->entries.size();
}

std::size_t PlaceDatabase::memory_bytes() const {
  std::size_t bytes = 0;
  for (const Impl::Entry& entry : impl_->entries) {
    bytes += sizeof(entry) + entry.bow.entries.capacity() * sizeof(WordCount);
  }
  return bytes;
}

}  // namespace deja_view
