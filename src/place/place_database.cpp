#include "deja_view/place/place_database.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "place_index.hpp"

namespace deja_view {
namespace {

using internal::IdfMode;
using internal::L1Norms;
using internal::PlaceIndex;
using internal::ScoreKind;
using internal::SquaredNorms;

void CheckBow(const BowVector& bow, std::size_t word_count) {
  DEJA_VIEW_CHECK_OP(bow.descriptor_count, <=, internal::kMaxDescriptors);
  for (std::size_t i = 0; i < bow.entries.size(); ++i) {
    DEJA_VIEW_CHECK_OP(bow.entries[i].word, <, word_count);
    DEJA_VIEW_CHECK_OP(bow.entries[i].count, >, 0U);
    DEJA_VIEW_CHECK(i == 0 || bow.entries[i - 1].word < bow.entries[i].word);
  }
}

}  // namespace

std::vector<std::string> PlaceDatabaseOptions::Validate() const {
  Requirements r;
  r.That(score == "l1" || score == "cosine", "score", score, "l1 or cosine");
  r.That(idf == "frozen" || idf == "running", "idf", idf, "frozen or running");
  return r.errors();
}

class PlaceDatabase::Impl {
 public:
  Impl(const PlaceDatabaseOptions& options, std::shared_ptr<const Vocabulary> vocabulary)
      : vocabulary_(std::move(vocabulary)),
        index_(MakeIndex(options.score == "l1",
                         options.idf == "running" ? IdfMode::kRunning : IdfMode::kFrozen)) {}

  template <typename F>
  auto Visit(F f) const {
    return std::visit(f, index_);
  }
  template <typename F>
  auto Visit(F f) {
    return std::visit(f, index_);
  }

  std::size_t word_count() const { return vocabulary_->word_count(); }

 private:
  using Index = std::variant<PlaceIndex<L1Norms>, PlaceIndex<SquaredNorms>>;

  Index MakeIndex(bool is_l1, IdfMode mode) const {
    if (is_l1) {
      return PlaceIndex<L1Norms>(mode, *vocabulary_);
    }
    return PlaceIndex<SquaredNorms>(mode, *vocabulary_);
  }

  std::shared_ptr<const Vocabulary> vocabulary_;
  Index index_;
};

PlaceDatabase::PlaceDatabase(const PlaceDatabaseOptions& options,
                             std::shared_ptr<const Vocabulary> vocabulary) {
  CheckNone(options.Validate(), "place database");
  DEJA_VIEW_CHECK(vocabulary != nullptr);
  impl_ = std::make_unique<Impl>(options, std::move(vocabulary));
}

PlaceDatabase::~PlaceDatabase() = default;
PlaceDatabase::PlaceDatabase(PlaceDatabase&&) noexcept = default;
PlaceDatabase& PlaceDatabase::operator=(PlaceDatabase&&) noexcept = default;

void PlaceDatabase::Add(int id, const BowVector& bow, int tag) {
  CheckBow(bow, impl_->word_count());
  impl_->Visit([&](auto& index) {
    DEJA_VIEW_CHECK(!index.Contains(id, tag));
    index.Add(id, tag, bow);
  });
}

bool PlaceDatabase::Remove(int id) {
  return impl_->Visit([&](auto& index) { return index.Remove(id); });
}

bool PlaceDatabase::Remove(int id, int tag) {
  return impl_->Visit([&](auto& index) { return index.Remove(id, tag); });
}

std::vector<PlaceMatch> PlaceDatabase::Query(const BowVector& bow, const PlaceQuery& query) const {
  CheckBow(bow, impl_->word_count());
  return impl_->Visit([&](const auto& index) { return internal::FindBest(index, bow, query); });
}

double PlaceDatabase::Score(const BowVector& a, const BowVector& b) const {
  CheckBow(a, impl_->word_count());
  CheckBow(b, impl_->word_count());
  return impl_->Visit([&](const auto& index) {
    using Index = std::decay_t<decltype(index)>;
    constexpr bool kIsL1 = std::is_same_v<Index, PlaceIndex<L1Norms>>;
    return internal::Similarity(kIsL1 ? ScoreKind::kL1 : ScoreKind::kCosine, index.weights(), a, b);
  });
}

std::size_t PlaceDatabase::size() const {
  return impl_->Visit([](const auto& index) { return index.size(); });
}

std::size_t PlaceDatabase::memory_bytes() const {
  return impl_->Visit([](const auto& index) { return index.memory_bytes(); });
}

}  // namespace deja_view
