#pragma once

#include "deja_view/scene/depth_maps.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace deja_view {

/// A flight: exactly one of bag and images is given.
struct FlightFiles {
  std::filesystem::path bag;
  std::filesystem::path images;  ///< OpenImageFlight
  std::filesystem::path camera;  ///< of ReadVinsConfig
  std::string image_topic;       ///< empty: the camera YAML's
};

/// What views are made of: a flight, its poses and a model of the scene.
struct ViewsInput {
  FlightFiles flight;
  std::string poses;  ///< ReadFlightPoses
  std::string poses_of = "body";
  std::string align_to = "auto";  ///< poses to compare with: auto (the VIO's in the bag, if any),
                                  ///< off, or ReadFlightPoses of the body
  std::filesystem::path model;    ///< a radiance field
  DepthMapFiles depth_maps;       ///< by which images are warped
  std::string preset = "paper";   ///< paper, wide, needed or a ViewOptions file
  std::vector<std::string> overrides;  ///< "group.key=value" on top
  std::string sources = "auto";        ///< SourceKind
  std::filesystem::path places;  ///< TUM: only images at its stamps; empty: as the preset says
  int threads = 0;
  bool show_progress = true;
};

/// What `deja_view views render` is told.
struct ViewsRenderRequest {
  ViewsInput input;
  std::string renderer = "nerf";  ///< one of SceneRenderers()
  std::string device = "auto";    ///< nerf::ChooseDevice
  std::string content = "image";  ///< or features, or both
  bool depth = false;
  bool plain_topics = false;
  bool views_only = false;
  bool resume = true;
  std::string shard = "0/1";
  std::filesystem::path out;
};

/// What `deja_view views merge` is told.
struct ViewsMergeRequest {
  FlightFiles flight;  ///< of a bag, the camera is not needed
  std::vector<std::filesystem::path> parts;
  std::filesystem::path out;
  bool views_only = false;
};

/// What `deja_view views check` is told.
struct ViewsCheckRequest {
  ViewsInput input;
  int count = 40;                 ///< images, spread over the flight
  std::filesystem::path network;  ///< FSRCNN; empty: the preset's
  std::vector<std::string> ways;  ///< direct, bicubic, patches, fsrcnn; empty: all
};

/// Makes the bag; returns `alignment, sub_map (of a sub-map's model), depth_maps (the images that
/// have one), images, without_pose, sources, resumed, not_recognised, views, not_free, uncertain,
/// bytes_per_view, source_psnr_db, source_ms_median, wall_s, peak_rss_mb`.
nlohmann::ordered_json RunViewsRender(const ViewsRenderRequest& request);

/// Returns `views, bytes_per_view`.
nlohmann::ordered_json RunViewsMerge(const ViewsMergeRequest& request);

/// Matches real images with their virtual views (the paper's Fig. 6); returns per way of making
/// them `views, visible, matched, correct, precision, render_ms_median, render_cpu_ms, bytes`,
/// means per view; and `not_recognised, not_free, uncertain, offers, alignment, images`. `offers`
/// has for each view its correct matches and the least gate.max_depth_sigma that lets it pass.
nlohmann::ordered_json RunViewsCheck(const ViewsCheckRequest& request);

}  // namespace deja_view
