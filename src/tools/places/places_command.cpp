#include <memory>
#include <string>

#include "common/commands.hpp"
#include "common/reporting.hpp"
#include "places/places_run.hpp"

namespace deja_view {

void AddPlacesCommand(CLI::App& app, Command* command) {
  auto request = std::make_shared<PlacesRequest>();
  CLI::App* sub = app.add_subcommand(
      "places", "Recognise places in a folder of images by appearance alone, without poses");
  AppearancePlacesOptions& options = request->options;
  sub->add_option("--images", request->images, "Directory; in order of names, colour as grey")
      ->required();
  sub->add_option("--groundtruth",
                  request->groundtruth,
                  "Text: N x N of 0 and 1 (row i, column j: image i shows j's place again), or "
                  "lines \"i: j j\"");
  sub->add_option("--out", request->out, "Directory for pairs.csv and pr_curve.csv");
  sub->add_option("--camera",
                  request->camera,
                  "Camera YAML of an odometry: essential matrix instead of fundamental");
  sub->add_option("--features", request->features, "brief or orb")
      ->check(CLI::IsMember({"brief", "orb"}))
      ->capture_default_str();
  sub->add_option("--vocabulary", request->vocabulary, "Vocabulary; the shipped one without");
  sub->add_option("--max-features", request->max_features, "Corners of an image, at most")
      ->capture_default_str();
  sub->add_option("--levels", request->levels, "Of ORB's pyramid")->capture_default_str();
  sub->add_option("--min-gap", options.min_gap, "Images between two of one place")
      ->capture_default_str();
  sub->add_option("--candidates", options.max_islands, "Groups of images that are compared")
      ->capture_default_str();
  sub->add_option("--consistency", options.consistency, "Images before that must agree")
      ->capture_default_str();
  sub->add_option("--max-ratio", options.two_view.max_ratio, "Nearest over second nearest match")
      ->capture_default_str();
  sub->add_option("--max-error", options.two_view.max_error_px, "To the epipolar line [px]")
      ->capture_default_str();
  sub->add_option("--threads", options.threads, "0: all cores; any gives the same pairs")
      ->capture_default_str();
  AddQuietOption(sub, &request->show_progress);
  sub->footer(
      "Example:\n  deja_view places --images lip6/images --groundtruth lip6/truth.txt --out places "
      "--json places.json");
  ReportOf(sub, command, RunPlaces, request);
}

}  // namespace deja_view
