#include "bundle_check.hpp"

#include "deja_view/base/check.hpp"

#include <cstddef>
#include <numeric>
#include <set>

namespace deja_view::internal {

void CheckProblem(const BundleProblem& problem) {
  const auto check_image = [&](int image) {
    DEJA_VIEW_CHECK(image >= 0 && static_cast<std::size_t>(image) < problem.images.size());
  };
  for (const BundleCamera& camera : problem.cameras) {
    DEJA_VIEW_CHECK(camera.camera != nullptr && camera.T_B_C.IsFinite());
  }
  for (const BundleImage& image : problem.images) {
    DEJA_VIEW_CHECK(image.camera >= 0 &&
                    static_cast<std::size_t>(image.camera) < problem.cameras.size());
    DEJA_VIEW_CHECK(image.T_W_B.IsFinite());
    DEJA_VIEW_CHECK_OP(image.keypoints.size(), ==, image.descriptors.size());
    DEJA_VIEW_CHECK_OP(image.keypoints.size(), ==, image.track_ids.size());
  }
  for (const RelativePosePrior& prior : problem.relative_priors) {
    check_image(prior.from);
    check_image(prior.to);
    DEJA_VIEW_CHECK(prior.from != prior.to && prior.T_from_to.IsFinite());
    DEJA_VIEW_CHECK(prior.sigma_m > 0 && prior.sigma_rad > 0);
  }
  for (const TiltPrior& prior : problem.tilt_priors) {
    check_image(prior.image);
    DEJA_VIEW_CHECK(prior.up_B.allFinite() && prior.sigma_rad > 0);
  }
  for (const PosePrior& prior : problem.pose_priors) {
    check_image(prior.image);
    DEJA_VIEW_CHECK(prior.T_W_B.IsFinite() && prior.sigma_m > 0 && prior.sigma_rad > 0);
  }
  for (const BundleLoop& loop : problem.loops) {
    check_image(loop.from);
    check_image(loop.to);
    DEJA_VIEW_CHECK(loop.T_from_to.IsFinite());
  }
}

std::string FindGap(const BundleProblem& problem, const std::vector<int>& points) {
  std::vector<std::size_t> group(problem.images.size() + 1);  // the last: the world
  std::iota(group.begin(), group.end(), 0);
  const auto find = [&](std::size_t i) {
    while (group[i] != i) {
      i = group[i] = group[group[i]];
    }
    return i;
  };
  const auto join = [&](int a, std::size_t b) {
    group[find(static_cast<std::size_t>(a))] = find(b);
  };
  for (const PosePrior& prior : problem.pose_priors) {
    join(prior.image, problem.images.size());
  }
  for (const RelativePosePrior& prior : problem.relative_priors) {
    join(prior.from, static_cast<std::size_t>(prior.to));
  }
  for (const int point : points) {
    const auto& observations = problem.points[static_cast<std::size_t>(point)].observations;
    for (const BundleObservation& o : observations) {
      join(o.image, static_cast<std::size_t>(observations.front().image));
    }
  }
  if (problem.pose_priors.empty()) {
    join(0, problem.images.size());
  }
  std::set<std::size_t> groups;
  for (std::size_t i = 0; i < group.size(); ++i) {
    groups.insert(find(i));
  }
  return groups.size() == 1 ? ""
                            : fmt::format(
                                  "the images fall into {} groups that neither points nor "
                                  "priors connect",
                                  groups.size());
}

}  // namespace deja_view::internal
