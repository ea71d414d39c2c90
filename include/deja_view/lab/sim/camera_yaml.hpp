#pragma once

#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <string>

namespace deja_view::sim {

/// The camera in VINS-Mono's YAML layout, as ReadVinsConfig and VINS-Mono itself read it.
std::string CameraYaml(const PinholeParameters& camera, const Rigid3& T_B_C);

}  // namespace deja_view::sim
