#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/host_choice.hpp"
#include <nlohmann/json.hpp>

namespace deja_view {

/// What `deja_view map` is told.
struct MapRequest {
  HostChoice host;
  std::filesystem::path bag;     ///< a flight: images and VINS-Mono's keyframes
  std::filesystem::path camera;  ///< of ReadVinsConfig
  double budget_s = 720;  ///< wall time in all; what adjusting leaves goes to field and views
  int steps = 0;          ///< of the field's training; 0: as many as the budget allows
  std::string preset = "needed";  ///< of the views: paper, wide, needed or a ViewOptions file
  std::vector<std::string> view_overrides;  ///< of the preset, "group.key=value"
  std::vector<std::string> overrides;       ///< of the loop closer, "group.key=value"
  int threads = 0;
  bool show_progress = true;
  std::filesystem::path
      add;  ///< a map of the place, to be joined; empty: a map of this flight alone
  std::filesystem::path out;
  std::filesystem::path bag_out;  ///< the flight with its views as messages, instead of views.bag
};

/// Makes a map that knows the place better than the flight did, from the flight alone: adjusts its
/// poses with the loops that it finds, trains a field on them, renders views of the map's places,
/// and saves the map with its views as `out`/map.dvm, the field as field.dvn, the adjusted poses as
/// bundle/poses.txt, the views as views.bag, `map.json`, and a page that shows it all, map.html.
/// What the views are worth is tried on the flight itself: its second half on a map of the first.
/// Each stage is kept with a hash of what it was made from and is not run again while that is the
/// same; a training that was interrupted goes on. Returns `bundle, field, field_quality, loops,
/// views, map, gain, cpu_s, wall_s, peak_rss_mb`, the stages' figures, and `flights`, what the map
/// is made of. Throws InputError, naming the stage, and Interrupted.
///
/// With `add` the flight is joined to a map of before, whose flights' bags must still be there: its
/// loops with that map's places tell where it was (`loops.join`: how well they agree; a flight that
/// finds too few, or whose loops contradict each other, is refused), the field goes on from that
/// map's with the images of all flights, and map.dvm holds their places and views. `field_quality`
/// then also has `before`, the same images rendered by the field as it was, and `others`, the
/// images of the flights before.
nlohmann::ordered_json RunMap(const MapRequest& request);

}  // namespace deja_view
