#pragma once

#include "deja_view/ros/view_bag.hpp"
#include "deja_view/views/pose_frame.hpp"

#include <memory>
#include <string>

#include "views_command.hpp"

namespace deja_view {

/// A job, but for its output, content and settings, and where its poses lie.
struct PosedJob {
  ViewJob job;
  PoseFrame poses;
};

/// Throws InputError unless exactly one of bag and images is given, images with a camera.
std::shared_ptr<const ViewFlight> OpenFlight(const FlightFiles& files);

/// What the input describes. Says on stderr how the poses fit those of the VIO, unless quiet.
PosedJob ReadViewsInput(const ViewsInput& input);

/// How the poses fit, or `{"not_checked": why}`.
nlohmann::ordered_json ToJson(const PoseFrame& frame);

/// The model, in the job's world.
std::shared_ptr<const ViewRenderer> ReadModel(const std::filesystem::path& path,
                                              const PoseFrame& frame);

/// Hash of a file's bytes; throws InputError that names it.
std::uint64_t HashFile(const std::filesystem::path& path);

/// Warps each image by the VIO's points.
ViewRendererFactory WarpFactory(std::shared_ptr<const Camera> camera);

}  // namespace deja_view
