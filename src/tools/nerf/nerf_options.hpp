#pragma once

#include "deja_view/nerf/options.hpp"
#include "deja_view/nerf/trainer.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace deja_view {

/// nerf::TrainOptions of a YAML file (empty: the defaults) with "group.key=value" on top. Throws
/// InputError.
nerf::TrainOptions ReadTrainOptions(const std::filesystem::path& config,
                                    const std::vector<std::string>& overrides,
                                    int threads);

/// The room that BoxAround is given when the user says nothing: with depth points the box holds
/// what was seen, without them it holds the cameras only.
double DefaultMargin(const std::vector<nerf::TrainingView>& views);

}  // namespace deja_view
