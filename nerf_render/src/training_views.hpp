#pragma once

#include "deja_view/nerf/training_view.hpp"

#include <vector>

namespace deja_view::nerf::internal {

/// Throws InputError that names the view for what can't be trained on: no views, an image of
/// another type, of another size than its camera, or with other channels than the first; a pose
/// that is no rigid transform.
void CheckViews(const std::vector<TrainingView>& views);

}  // namespace deja_view::nerf::internal
