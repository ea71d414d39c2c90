#pragma once

#include "deja_view/lab/sim/options.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace deja_view {

/// What `deja_view simulate` is told.
struct SimulateRequest {
  std::string preset = "hall";
  std::filesystem::path config;        ///< SimOptions; empty: the preset alone
  std::vector<std::string> overrides;  ///< "group.key=value" on top
  std::filesystem::path out;
  bool bag = false;           ///< write flight.bag
  std::string images;         ///< "png", "jpg" or "none"; empty: png when there is no bag
  bool ranges = false;        ///< write exact ranges
  std::string virtual_views;  ///< ExactViewOptions preset, into the bag; empty: none
  /// TUM file whose stamps name the images to render views of: no flight is made then, only
  /// views.bag with the exact views. Empty: views of all keyframes go into the flight's bag.
  std::filesystem::path views_for;
  /// Bag with virtual views of that flight: the same, at their poses. Empty: at `virtual_views`'s.
  std::filesystem::path views_like;
  std::string virtual_content = "features";  ///< "features", "image" or "both"
  bool show_progress = true;
};

/// The preset with the config file and the overrides on top. Throws InputError.
sim::SimOptions ReadSimOptions(const SimulateRequest& request);

}  // namespace deja_view
