#include "nerf/nerf_options.hpp"

#include "deja_view/io/options_yaml.hpp"

#include <algorithm>

namespace deja_view {

nerf::TrainOptions ReadTrainOptions(const std::filesystem::path& config,
                                    const std::vector<std::string>& overrides,
                                    int threads) {
  nerf::TrainOptions options;
  ReadOptions(config, overrides, &options);
  options.threads = threads;
  return options;
}

double DefaultMargin(const std::vector<nerf::TrainingView>& views) {
  const bool has_points = std::any_of(
      views.begin(), views.end(), [](const nerf::TrainingView& v) { return !v.points.empty(); });
  return has_points ? 0.05 : 0.6;
}

}  // namespace deja_view
