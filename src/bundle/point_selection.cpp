#include "point_selection.hpp"

#include <algorithm>
#include <numeric>

namespace deja_view::internal {
namespace {

constexpr int kColumns = 6;
constexpr int kRows = 4;

std::size_t CellOf(const BundleProblem& problem, const BundleObservation& o) {
  const BundleImage& image = problem.images[static_cast<std::size_t>(o.image)];
  const Camera& camera = *problem.cameras[static_cast<std::size_t>(image.camera)].camera;
  const Eigen::Vector2f& pixel = image.keypoints[static_cast<std::size_t>(o.keypoint)];
  const auto part = [](float x, int size, int parts) {
    return std::clamp(
        static_cast<int>(x * static_cast<float>(parts) / static_cast<float>(size)), 0, parts - 1);
  };
  const int cell = (o.image * kRows + part(pixel.y(), camera.height(), kRows)) * kColumns +
                   part(pixel.x(), camera.width(), kColumns);
  return static_cast<std::size_t>(cell);
}

}  // namespace

std::vector<int> SelectPoints(const BundleProblem& problem, int per_image) {
  std::vector<int> order(problem.points.size());
  std::iota(order.begin(), order.end(), 0);
  if (per_image == 0) {
    return order;
  }
  const auto views = [&](int point) {
    return problem.points[static_cast<std::size_t>(point)].observations.size();
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return views(a) > views(b); });
  const int per_cell = std::max(1, per_image / (kColumns * kRows));
  std::vector<int> in_cell(problem.images.size() * kColumns * kRows, 0);
  std::vector<int> in_image(problem.images.size(), 0);
  std::vector<int> selected;
  std::vector<char> is_selected(problem.points.size(), 0);
  const auto select = [&](int point) {
    is_selected[static_cast<std::size_t>(point)] = 1;
    selected.push_back(point);
    for (const BundleObservation& o :
         problem.points[static_cast<std::size_t>(point)].observations) {
      ++in_cell[CellOf(problem, o)];
      ++in_image[static_cast<std::size_t>(o.image)];
    }
  };
  // First where a cell of an image lacks points, then where an image does.
  const auto fill = [&](auto&& lacks) {
    constexpr std::size_t kLacking = 2;  // images that must profit
    for (const int point : order) {
      const auto& observations = problem.points[static_cast<std::size_t>(point)].observations;
      const auto lacking = std::count_if(observations.begin(), observations.end(), lacks);
      if (is_selected[static_cast<std::size_t>(point)] == 0 &&
          static_cast<std::size_t>(lacking) >= kLacking) {
        select(point);
      }
    }
  };
  fill([&](const BundleObservation& o) { return in_cell[CellOf(problem, o)] < per_cell; });
  fill([&](const BundleObservation& o) {
    return in_image[static_cast<std::size_t>(o.image)] < per_image;
  });
  std::sort(selected.begin(), selected.end());
  return selected;
}

}  // namespace deja_view::internal
