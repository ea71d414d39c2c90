#pragma once

#include "deja_view/nerf/radiance_field.hpp"
#include "deja_view/nerf/training_view.hpp"

#include <vector>

namespace deja_view::nerf {

/// The box about the cameras and all but the outermost of the depth points, `margin` times its own
/// diagonal larger on every side. Throws InputError where all is in one place.
SceneBox BoxAround(const std::vector<TrainingView>& views, double margin);

}  // namespace deja_view::nerf
