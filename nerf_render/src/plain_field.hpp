#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/nerf/radiance_field.hpp"

#include <cstddef>

#include "device_engine.hpp"

namespace deja_view::nerf::internal {

/// Cameras, poses and fields as the plain numbers that a device takes.

LensView LensOf(const Camera& camera);
PlainPose PlainPoseOf(const Rigid3& pose);
FieldLayout LayoutOf(const RadianceField& field);
DeviceEngine::ConstArrays ArraysOf(const RadianceField& field);

/// Numbers of a field that a device has changed. `words` receives those of the occupancy grid.
DeviceEngine::Arrays ArraysOf(RadianceField* field, std::vector<std::uint64_t>* words);

/// What a field's numbers take on a device [byte].
std::size_t BytesOf(const RadianceField& field);

}  // namespace deja_view::nerf::internal
