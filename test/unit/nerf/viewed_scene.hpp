#pragma once

#include "deja_view/nerf/training_view.hpp"

#include <cstdint>
#include <memory>

#include <opencv2/core.hpp>

namespace deja_view::nerf {

/// The view that a camera has of a scene; `grey` (0 to 255) takes each pixel's ray in N.
template <typename Grey>
TrainingView ViewOf(const std::shared_ptr<const Camera>& camera,
                    const Rigid3& T_N_C,
                    const Grey& grey) {
  TrainingView view;
  view.camera = camera;
  view.T_N_C = T_N_C;
  view.image.create(camera->height(), camera->width(), CV_8UC1);
  for (int y = 0; y < camera->height(); ++y) {
    for (int x = 0; x < camera->width(); ++x) {
      const Eigen::Vector3d ray = T_N_C.q * camera->Unproject({x, y});
      view.image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(grey(ray));
    }
  }
  return view;
}

}  // namespace deja_view::nerf
