#pragma once

#include "deja_view/appearance/two_view.hpp"
#include "deja_view/features/types.hpp"
#include "deja_view/place/place_database.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <memory>
#include <string>
#include <vector>

namespace deja_view {

/// How places are recognised by images alone.
struct AppearancePlacesOptions {
  int min_gap = 100;         ///< images between two of one place, >= 1
  int max_results = 50;      ///< places that words propose, >= 1
  int island_gap = 5;        ///< proposals at most so many images apart are one island, >= 1
  int max_islands = 5;       ///< islands whose best image is compared, >= 1
  int consistency = 0;       ///< earlier images that must agree, >= 0
  int consistency_gap = 10;  ///< images by which agreeing matches may differ, >= 1
  int threads = 1;           ///< 0: all cores; the result is the same for any number
  PlaceDatabaseOptions database;
  TwoViewOptions two_view;

  /// Violations, one line each; empty when all is well.
  std::vector<std::string> Validate() const;
};

/// Neighbouring images that words propose together.
struct PlaceIsland {
  int id = -1;         ///< of its best image
  double score = 0;    ///< of that image
  double support = 0;  ///< sum over the island

  friend bool operator==(const PlaceIsland& a, const PlaceIsland& b) {
    return a.id == b.id && a.score == b.score && a.support == b.support;
  }
};

/// Groups `matches` (any order) where ids are at most `island_gap` apart; largest support first,
/// of equal ones the lowest id (Galvez-Lopez and Tardos, T-RO 2012, Sec. V-B).
std::vector<PlaceIsland> GroupIslands(std::vector<PlaceMatch> matches, int island_gap);

/// The earlier image that an image looks most like.
struct AppearanceMatch {
  int id = -1;            ///< -1: none
  double similarity = 0;  ///< of the words
  int matches = 0;
  int inliers = 0;
  /// What a threshold applies to: the inliers, or, with `consistency`, the fewest among this
  /// match's and those of as many images before, 0 where one of them disagrees.
  double score = 0;
};

/// Seconds spent on one image.
struct AppearanceTimes {
  double words = 0;
  double query = 0;
  double two_view = 0;
};

/// Recognises places by words and two-view geometry, image by image, without poses.
class AppearancePlaces {
 public:
  /// Throws CheckError for invalid options.
  AppearancePlaces(const AppearancePlacesOptions& options,
                   std::shared_ptr<const Vocabulary> vocabulary);

  /// Looks for the image among those at least `min_gap` before it, then adds it. Ids count from 0.
  AppearanceMatch Add(Features features, AppearanceTimes* times = nullptr);

  int size() const { return static_cast<int>(images_.size()); }

 private:
  AppearanceMatch BestOf(const std::vector<PlaceIsland>& islands, const Features& features) const;
  double Score(const AppearanceMatch& match) const;

  AppearancePlacesOptions options_;
  std::shared_ptr<const Vocabulary> vocabulary_;
  PlaceDatabase database_;
  std::vector<Features> images_;
  std::vector<AppearanceMatch> found_;  ///< of each image
};

}  // namespace deja_view
