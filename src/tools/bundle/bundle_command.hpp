#pragma once

#include "deja_view/bundle/bundle_adjuster.hpp"
#include "deja_view/bundle/bundle_priors.hpp"
#include "deja_view/features/feature_options.hpp"

#include <filesystem>
#include <string>
#include <vector>

#include "common/host_choice.hpp"
#include "nerf/nerf_input.hpp"
#include <nlohmann/json.hpp>

namespace deja_view {

class Interrupt;

/// Everything that `deja_view bundle` can be told by --config and --set.
struct BundleToolOptions {
  BriefOptions features;
  BundleOptions bundle;
  BundlePriorOptions priors;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("features", features);
    v("bundle", bundle);
    v("priors", priors);
  }
};

/// What `deja_view bundle` is told.
struct BundleRequest {
  HostChoice host;        ///< of a flight
  NerfInput input;        ///< posed images; or a flight: `bag` and `camera` without poses
  bool use_loops = true;  ///< of a flight: close its loops first
  std::filesystem::path vocabulary;  ///< for loops; empty: the shipped one
  std::filesystem::path config;
  std::vector<std::string> overrides;
  std::vector<std::string> refine;  ///< of the cameras, beside what the options refine
  std::filesystem::path out;
  bool write_images = false;  ///< of a flight, beside its model
  bool show_progress = true;

  bool IsFlight() const;
};

/// A problem and what its images are called.
struct BundleInput {
  BundleProblem problem;
  std::vector<std::string> names;  ///< of the images, within their folder
  std::vector<std::string> warnings;
};

/// The keyframes of VINS-Mono's topics in a bag, with the VIO's tracks, its relative poses and
/// gravity as priors, and the loops that a replay finds. Throws InputError, and
/// Interrupted after Ctrl-C.
BundleInput ReadFlight(const BundleRequest& request,
                       const BundleToolOptions& options,
                       const Interrupt& interrupt);

/// Images with given poses, which become priors. Throws InputError.
BundleInput ReadPosedImages(const BundleRequest& request, const BundleToolOptions& options);

/// Adjusts and writes `poses.txt` (TUM: bodies of a flight, else cameras), `colmap/` and
/// `bundle.json` to request.out. Returns the JSON. After Ctrl-C it writes what the rounds that were
/// finished gave and says so ("interrupted"), or throws Interrupted before there is any. Throws
/// InputError, also for input that can't be adjusted.
nlohmann::ordered_json RunBundle(const BundleRequest& request);

}  // namespace deja_view
