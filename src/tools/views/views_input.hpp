#pragma once

#include "deja_view/ros/bag/view_bag.hpp"
#include "deja_view/scene/depth_maps.hpp"
#include "deja_view/views/pose_frame.hpp"
#include "deja_view/views/scene_model.hpp"

#include <memory>
#include <string>

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

/// A scene in the job's world.
struct ViewModel {
  ViewRendererFactory renderers;
  ViewSubMap sub_map;    ///< what it is the model of
  std::string settings;  ///< which model it is, or of sub-maps: how the scene is cut
};

/// Throws InputError for a model whose place among the poses nobody knows.
ViewModel PlaceModel(const std::shared_ptr<const SceneModel>& model, const PosedJob& posed);

/// Null where there are none. Throws InputError when none of the flight's images has one.
std::shared_ptr<const DepthMaps> OpenFlightMaps(const DepthMapFiles& files, const ViewJob& job);

/// How many images of the flight have a depth map.
std::size_t CountDepthMaps(const DepthMaps& maps, const ViewJob& job);

}  // namespace deja_view
