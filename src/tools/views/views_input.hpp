#pragma once

#include "deja_view/ros/bag/view_bag.hpp"
#include "deja_view/views/pose_frame.hpp"

#include <memory>
#include <string>

#include "views/depth_maps.hpp"
#include "views/views_command.hpp"

namespace deja_view {

/// A job, but for its output, content and settings, and where its poses lie.
struct PosedJob {
  ViewJob job;
  PoseFrame poses;
  bool tell_model_frame = false;  ///< the poses are the model's own: poses.W_N is its place
};

/// Throws InputError unless exactly one of bag and images is given, images with a camera.
std::shared_ptr<const ViewFlight> OpenFlight(const FlightFiles& files);

/// What the input describes. Says on stderr how the poses fit those of the VIO, unless quiet.
PosedJob ReadViewsInput(const ViewsInput& input);

/// How the poses fit, or `{"not_checked": why}`.
nlohmann::ordered_json ToJson(const PoseFrame& frame);

/// A radiance field, in the job's world.
struct ViewModel {
  std::shared_ptr<const ViewRenderer> renderer;
  ViewSubMap sub_map;    ///< what it is the model of
  std::string settings;  ///< which model it is, or of sub-maps: how the scene is cut; a line
};

/// Throws InputError, also for a model whose place among the poses nobody knows.
ViewModel ReadModel(const std::filesystem::path& path, const PosedJob& posed);

/// Hash of a file's bytes; throws InputError that names it.
std::uint64_t HashFile(const std::filesystem::path& path);

/// Warps each image by its depth map where `maps` has one, by the VIO's points otherwise. `maps`
/// may be null.
ViewRendererFactory WarpFactory(std::shared_ptr<const Camera> camera,
                                std::shared_ptr<const DepthMaps> maps);

}  // namespace deja_view
