#pragma once

#include "deja_view/features/feature_options.hpp"
#include "deja_view/place/place_database.hpp"
#include "deja_view/place/scored_places.hpp"
#include "deja_view/pose_graph/loop_consistency.hpp"
#include "deja_view/pose_graph/pose_graph.hpp"
#include "deja_view/triangulation/motion_stereo.hpp"
#include "deja_view/verification/loop_verifier.hpp"

#include <string>
#include <vector>

namespace deja_view {

/// Which keyframes are tried against the current one.
struct CandidateOptions {
  double min_age_s = 10.0;     ///< [s] an old keyframe of the same sequence must be older than this
  int retrieved = 20;          ///< entries asked from the place database
  double min_score = 0.0;      ///< place score below which an entry is not tried
  double island_gap_s = 1.5;   ///< [s] retrieved keyframes closer than this form one island
  int members_per_island = 2;  ///< best members of an island that are verified
  int max_verified = 8;        ///< candidates verified per keyframe at most
  int max_loops = 3;           ///< a keyframe that has so many loops is not verified further
  /// Nor is one whose loop is with a place that had so many before, and is no surprise. 0: it is.
  int known_loops = 80;
  // Where the corrected trajectory says that the drone has been.
  int nearby = 3;                  ///< keyframes near the corrected pose that are tried, 0: none
  double nearby_distance_m = 3.0;  ///< [m]
  double nearby_angle_deg = 45.0;  ///< [deg] between the cameras' axes

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("min_age_s", min_age_s);
    v("retrieved", retrieved);
    v("min_score", min_score);
    v("island_gap_s", island_gap_s);
    v("members_per_island", members_per_island);
    v("max_verified", max_verified);
    v("max_loops", max_loops);
    v("known_loops", known_loops);
    v("nearby", nearby);
    v("nearby_distance_m", nearby_distance_m);
    v("nearby_angle_deg", nearby_angle_deg);
  }
  std::vector<std::string> Validate() const;
};

/// When the pose graph is solved.
struct SolveOptions {
  int every_loops = 100;  ///< accepted loops after which the graph is solved
  double surprise =
      4.0;  ///< [sigma] a loop that disagrees more with the present state: solved at once
  int most_nodes = 500;  ///< that are solved where no loop was a surprise: the newest, and around
  int latency = 2;       ///< keyframes until a solution is taken over...
  int nodes_per_latency =
      300;  ///< ...and one more per so many nodes, so that it never has to be waited for
  int measurement_latency =
      12;              ///< keyframes from a loop until the VIO's own measurement of it is used
  bool at_end = true;  ///< OptimizeFully solves to convergence

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("every_loops", every_loops);
    v("surprise", surprise);
    v("most_nodes", most_nodes);
    v("latency", latency);
    v("nodes_per_latency", nodes_per_latency);
    v("measurement_latency", measurement_latency);
    v("at_end", at_end);
  }
  std::vector<std::string> Validate() const;
};

/// Which tracked points are used, and how well their depth is known: with depth d [m] and parallax
/// angle a [rad] over the track, sigma / d = hypot(floor, track_sigma_px / (focal length a)), at
/// most max.
struct TrackDepthOptions {
  double max_error_px = 4.0;  ///< points that miss their own pixel by more are left out
  double max_depth_m = 60.0;  ///< [m]
  double sigma_floor = 0.02;
  double track_sigma_px = 1.0;
  double sigma_max = 0.15;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("max_point_error_px", max_error_px);
    v("max_point_depth_m", max_depth_m);
    v("point_sigma_floor", sigma_floor);
    v("point_track_sigma_px", track_sigma_px);
    v("point_sigma_max", sigma_max);
  }
  std::vector<std::string> Validate() const;
};

/// Which virtual views are kept, and of what use they are.
struct VirtualViewOptions {
  /// Views kept per keyframe: those most like their own source image by L1 similarity
  /// (1 is the paper's choice, Sec. 3.2.3). 0: none, not even a loaded map's.
  int keep = 8;
  int max_features = 350;   ///< strongest, spread over the image
  int in_rig = 1;           ///< of a keyframe's views, those nearest to where the drone should be,
                            ///< or else those that look most like its image
  int rigs = 2;             ///< of a keyframe tried, one after the other, each with the next views
  int max_tried = 6;        ///< candidates per keyframe that are verified with their views
  int max_waiting = 400;    ///< views whose keyframe has not come yet; the oldest is given up first
  int max_waiting_mb = 64;  ///< the same of their images and features [MiB]
  bool use_offline = true;  ///< take a message's own features where it has them
  double min_certainty = 0.5;  ///< of a pixel (1: certain): a keypoint below is not used
  int min_features = 30;       ///< certain keypoints that a view must have
  /// Of the points that view and source image should share, the part found in both.
  double min_agreement = 0.15;
  int min_judged = 20;                ///< with fewer points to share, agreement is not judged
  double max_depth_sigma = 0.06;      ///< over the depth: a keypoint above is no 3-D point
  double unknown_depth_sigma = 0.02;  ///< over the depth, where a view has depth without sigma

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("keep", keep);
    v("max_features", max_features);
    v("in_rig", in_rig);
    v("rigs", rigs);
    v("max_tried", max_tried);
    v("max_waiting", max_waiting);
    v("max_waiting_mb", max_waiting_mb);
    v("use_offline", use_offline);
    v("min_certainty", min_certainty);
    v("min_features", min_features);
    v("min_agreement", min_agreement);
    v("min_judged", min_judged);
    v("max_depth_sigma", max_depth_sigma);
    v("unknown_depth_sigma", unknown_depth_sigma);
  }
  std::vector<std::string> Validate() const;
};

/// When a keyframe sees what no place has seen from where it is: a place covers a point that falls
/// into its image from about the same direction and distance.
struct PlaceCoverOptions {
  double min_share = 0.7;      ///< of a keyframe's points that one place must cover to stand for it
  double max_angle_deg = 8.0;  ///< [deg] between the two cameras' rays to a point
  double max_scale = 1.25;     ///< of their distances to it, the larger over the smaller

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("min_share", min_share);
    v("max_angle_deg", max_angle_deg);
    v("max_scale", max_scale);
  }
  std::vector<std::string> Validate() const;
};

/// Everything that LoopCloser can be told; `Validate` lists all violations at once.
struct LoopCloserOptions {
  FeatureOptions features;
  PlaceDatabaseOptions place;
  ScoringOptions scoring;
  CandidateOptions candidates;
  LoopVerifierOptions verification;
  LoopConsistencyOptions consistency;
  PoseGraphOptions pose_graph;
  SolveOptions solve;
  VirtualViewOptions views;
  /// False: keyframes only look for the places of a loaded map, and become none themselves.
  bool add_places = true;
  /// A keyframe becomes a place to recognise only where the map lacks one: below 0, none that
  /// covers what it sees (map_cover); else none within this distance and angle; 0: every keyframe
  /// does.
  double map_spacing_m = -1.0;
  double map_spacing_deg = 30.0;
  PlaceCoverOptions map_cover;
  double max_speed_mps =
      40.0;  ///< [m/s] a faster jump between keyframes means that the VIO started anew
  TrackDepthOptions track_depths;
  /// Points of the keyframes' own corners, beside those that the VIO tracks.
  MotionStereoOptions motion_stereo;

  /// Kind of offline features that make a view's images needless; empty: none does.
  std::string SufficientViewFeatures() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("features", features);
    v("place", place);
    v("scoring", scoring);
    v("candidates", candidates);
    v("verification", verification);
    v("consistency", consistency);
    v("pose_graph", pose_graph);
    v("solve", solve);
    v("views", views);
    v("motion_stereo", motion_stereo);
    v("add_places", add_places);
    v("map_spacing_m", map_spacing_m);
    v("map_spacing_deg", map_spacing_deg);
    v("map_cover", map_cover);
    v("max_speed_mps", max_speed_mps);
    track_depths.Visit(v);
  }
  std::vector<std::string> Validate() const;
};

}  // namespace deja_view
