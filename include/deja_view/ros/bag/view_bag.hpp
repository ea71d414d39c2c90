#pragma once

#include "deja_view/base/shard.hpp"
#include "deja_view/ros/bag/view_flight.hpp"
#include "deja_view/ros/bag/view_store.hpp"
#include "deja_view/ros/bag/view_topics.hpp"
#include "deja_view/views/scene_model.hpp"
#include "deja_view/views/view_maker.hpp"
#include "deja_view/views/view_sources.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace deja_view {

/// A part of a scene that has a model of its own.
struct ViewSubMap {
  Shard shard;  ///< one of how many; a count of 1: the model is of all
  /// Whether the model is there for a camera at this place of the job's world. Every place is one
  /// sub-map's.
  std::function<bool(const Eigen::Vector3d& p_N)> is_own;
  std::string settings;  ///< what only this one's views depend on, in one line: its model
};

/// From a flight to a bag of it with virtual views.
struct ViewJob {
  std::shared_ptr<const ViewFlight> flight;
  std::filesystem::path out;
  VioTopics topics;
  SourceKind sources = SourceKind::kAuto;
  std::shared_ptr<const Camera> camera;
  Rigid3 T_B_C;      ///< of the VIO, whose tracked points a renderer may want, and of pose_topic
  Trajectory T_N_C;  ///< [m]
  /// Only the images at these stamps get views, all of them; empty: those that options.sources
  /// says.
  std::vector<std::int64_t> source_stamps_ns;
  ViewOptions options;
  ViewContent content;
  std::string settings;  ///< all that decides what the views look like, as text; goes to the bag
  Shard shard;           ///< of more than one: only the share's views are written, for MergeViews
  ViewSubMap sub_map;    ///< of more than one: as well, and only its own images get views
  /// nav_msgs/Odometry of the body at the images, for a flight that has no poses of its own; empty:
  /// none.
  std::string pose_topic;
  bool plain_topics = false;  ///< also Image, CameraInfo and PoseStamped, for rqt and RViz
  bool views_only = false;    ///< without the flight's own messages
  bool resume = true;         ///< use finished results of the same settings
  int threads = 0;
};

/// What was made.
struct ViewReport {
  std::int64_t images = 0;        ///< with a pose
  std::int64_t without_pose = 0;  ///< images
  std::int64_t sources = 0;       ///< images that were to get views, of this share
  std::int64_t resumed = 0;       ///< sources whose results were there already
  std::int64_t not_recognised = 0;
  std::int64_t views = 0;
  std::int64_t not_free = 0;
  std::int64_t uncertain = 0;
  std::int64_t bytes = 0;              ///< of all VirtualFrame messages
  std::vector<double> source_s;        ///< time per source, on one thread of several
  std::vector<double> source_psnr_db;  ///< renders at the sources' own poses, small
};

/// What RenderViews is at.
enum class ViewStep {
  kChoosing,   ///< poses for all images together; counted in rounds, two per image
  kRendering,  ///< counted in images
};

using ViewProgress = std::function<void(ViewStep step, std::size_t done, std::size_t total)>;

/// Renders the views of a flight's images and writes the new bag: all messages of the flight, byte
/// for byte, and the views right behind their source images, 1 ns apart. What is finished is kept
/// in the directory `out`.work until the bag is whole. `on_progress(step, done, total)` is called
/// by one thread at a time, and may throw to interrupt. The same job gives the same file, however
/// often it was interrupted.
///
/// Throws InputError for bad input, and when no source image at all is recognised: the poses are
/// then not in the model's frame.
ViewReport RenderViews(const ViewJob& job,
                       const ViewRendererFactory& make_renderer,
                       const ViewProgress& on_progress);

/// Puts the shares together, of all sub-maps: gives the same file as RenderViews in one run, as its
/// job's `views_only` says with the flight's own messages or without. Throws InputError when a part
/// is missing or given twice, or when they were made with different settings or of another flight.
ViewReport MergeViews(const ViewFlight& flight,
                      const std::vector<std::filesystem::path>& parts,
                      const std::filesystem::path& out,
                      bool views_only = false);

}  // namespace deja_view
