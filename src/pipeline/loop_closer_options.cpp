#include "deja_view/pipeline/loop_closer_options.hpp"

#include "deja_view/base/enum_names.hpp"
#include "deja_view/base/requirements.hpp"

#include <cmath>

namespace deja_view {

std::vector<std::string> CandidateOptions::Validate() const {
  Requirements r;
  r.That(min_age_s > 0, "min_age_s", min_age_s, "more than 0");
  r.That(retrieved >= 0, "retrieved", retrieved, "at least 0");
  r.That(island_gap_s >= 0, "island_gap_s", island_gap_s, "at least 0");
  r.That(max_loops >= 1, "max_loops", max_loops, "at least 1");
  r.That(known_loops >= 0, "known_loops", known_loops, "at least 0");
  r.That(members_per_island >= 1, "members_per_island", members_per_island, "at least 1");
  r.That(max_verified >= 1, "max_verified", max_verified, "at least 1");
  r.That(nearby >= 0, "nearby", nearby, "at least 0");
  r.That(nearby_distance_m > 0, "nearby_distance_m", nearby_distance_m, "more than 0");
  r.That(nearby_angle_deg > 0, "nearby_angle_deg", nearby_angle_deg, "more than 0");
  return r.errors();
}

std::vector<std::string> SolveOptions::Validate() const {
  Requirements r;
  r.That(every_loops >= 1, "every_loops", every_loops, "at least 1");
  r.That(surprise > 0, "surprise", surprise, "more than 0");
  r.That(most_nodes >= 1, "most_nodes", most_nodes, "at least 1");
  r.That(latency >= 1, "latency", latency, "at least 1");
  r.That(nodes_per_latency >= 1, "nodes_per_latency", nodes_per_latency, "at least 1");
  r.That(measurement_latency >= 1, "measurement_latency", measurement_latency, "at least 1");
  return r.errors();
}

std::vector<std::string> TrackDepthOptions::Validate() const {
  Requirements r;
  r.That(max_error_px > 0, "max_point_error_px", max_error_px, "more than 0");
  r.That(max_depth_m > 0, "max_point_depth_m", max_depth_m, "more than 0");
  r.That(sigma_floor > 0, "point_sigma_floor", sigma_floor, "more than 0");
  r.That(track_sigma_px >= 0, "point_track_sigma_px", track_sigma_px, "at least 0");
  r.That(sigma_max >= sigma_floor, "point_sigma_max", sigma_max, "point_sigma_floor or more");
  return r.errors();
}

std::vector<std::string> PlaceCoverOptions::Validate() const {
  Requirements r;
  r.Range("min_share", min_share, 0, 1);
  r.That(max_angle_deg > 0, "max_angle_deg", max_angle_deg, "more than 0");
  r.That(max_scale > 1, "max_scale", max_scale, "more than 1");
  return r.errors();
}

std::vector<std::string> VirtualViewOptions::Validate() const {
  Requirements r;
  r.That(keep >= 0, "keep", keep, "at least 0");
  r.That(max_features >= 1, "max_features", max_features, "at least 1");
  r.That(in_rig >= 1, "in_rig", in_rig, "at least 1");
  r.That(rigs >= 1, "rigs", rigs, "at least 1");
  r.That(max_tried >= 0, "max_tried", max_tried, "at least 0");
  r.That(max_waiting >= 0, "max_waiting", max_waiting, "at least 0");
  r.That(max_waiting_mb >= 0, "max_waiting_mb", max_waiting_mb, "at least 0");
  r.Range("min_certainty", min_certainty, 0, 1);
  r.That(min_features >= 1, "min_features", min_features, "at least 1");
  r.Range("min_agreement", min_agreement, 0, 1);
  r.That(min_judged >= 1, "min_judged", min_judged, "at least 1");
  r.That(max_depth_sigma > 0, "max_depth_sigma", max_depth_sigma, "more than 0");
  r.That(unknown_depth_sigma > 0, "unknown_depth_sigma", unknown_depth_sigma, "more than 0");
  return r.errors();
}

std::string LoopCloserOptions::SufficientViewFeatures() const {
  return views.use_offline ? EnumToString(features.kind) : "";
}

std::vector<std::string> LoopCloserOptions::Validate() const {
  Requirements r;
  r.Group("features", features.Validate());
  r.Group("verification", verification.Validate());
  r.Group("consistency", consistency.Validate());
  r.Group("place", place.Validate());
  r.Group("scoring", scoring.Validate());
  r.Group("pose_graph", pose_graph.Validate());
  r.Group("views", views.Validate());
  r.Group("motion_stereo", motion_stereo.Validate());
  r.Group("candidates", candidates.Validate());
  r.Group("solve", solve.Validate());
  r.Group("map_cover", map_cover.Validate());
  r.That(!std::isnan(map_spacing_m), "map_spacing_m", map_spacing_m, "a number");
  r.That(map_spacing_deg > 0, "map_spacing_deg", map_spacing_deg, "more than 0");
  r.That(max_speed_mps > 0, "max_speed_mps", max_speed_mps, "more than 0");
  for (const std::string& error : track_depths.Validate()) {  // no group in the file either
    r.That(false, error);
  }
  return r.errors();
}

}  // namespace deja_view
