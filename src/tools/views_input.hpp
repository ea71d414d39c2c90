#pragma once

#include "deja_view/nerf/field_renderer.hpp"
#include "deja_view/ros/view_bag.hpp"

#include <memory>
#include <string>

#include "views_command.hpp"

namespace deja_view {

/// The job that the input describes, but for its output, content and settings.
ViewJob ReadViewsInput(const ViewsInput& input);

std::shared_ptr<const nerf::FieldRenderer> ReadModel(const std::filesystem::path& path);

/// Hash of a file's bytes; throws InputError that names it.
std::uint64_t HashFile(const std::filesystem::path& path);

/// Warps each image by the VIO's points.
ViewRendererFactory WarpFactory(std::shared_ptr<const Camera> camera);

}  // namespace deja_view
