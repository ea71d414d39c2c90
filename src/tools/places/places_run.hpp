#pragma once

#include "deja_view/appearance/appearance_places.hpp"
#include "deja_view/features/feature_options.hpp"

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

namespace deja_view {

/// What `deja_view places` is told.
struct PlacesRequest {
  std::filesystem::path images;       ///< directory
  std::filesystem::path groundtruth;  ///< empty: pairs are not judged
  std::filesystem::path camera;       ///< empty: fundamental matrix
  std::filesystem::path vocabulary;   ///< empty: the shipped one of the features
  std::filesystem::path out;          ///< directory of the CSV files; empty: none
  std::string features = "brief";
  int max_features = 1000;
  int levels = 1;  ///< of ORB's pyramid
  AppearancePlacesOptions options;
  bool show_progress = true;
};

/// Recognises places in a folder of images, in order of their names, by appearance alone. Returns
/// the figures; with `out`, writes `pairs.csv` and, with a truth, `pr_curve.csv` there. Throws
/// InputError that names the file for images that can't be read or are of another size than the
/// first, a truth of another number of images and a vocabulary of other features.
nlohmann::ordered_json RunPlaces(const PlacesRequest& request);

}  // namespace deja_view
