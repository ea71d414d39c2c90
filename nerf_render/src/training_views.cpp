#include "training_views.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>

namespace deja_view::nerf::internal {

void CheckViews(const std::vector<TrainingView>& views) {
  if (views.empty()) {
    ThrowInputError("training: expected at least one posed image, found none");
  }
  for (const TrainingView& view : views) {
    if (view.image.type() != CV_8UC1 && view.image.type() != CV_8UC3) {
      ThrowInputError("{}: expected an 8-bit image of one or three channels", view.name);
    }
    if (view.image.cols != view.camera->width() || view.image.rows != view.camera->height()) {
      ThrowInputError("{}: the image is {}x{}, its camera {}x{}",
                      view.name,
                      view.image.cols,
                      view.image.rows,
                      view.camera->width(),
                      view.camera->height());
    }
    if (view.image.channels() != views.front().image.channels()) {
      ThrowInputError("{}: has {} channels, {} has {}",
                      view.name,
                      view.image.channels(),
                      views.front().name,
                      views.front().image.channels());
    }
    if (!view.T_N_C.IsFinite() || std::abs(view.T_N_C.q.norm() - 1) > 1e-6) {
      ThrowInputError("{}: its pose is not a rigid transform", view.name);
    }
  }
}

}  // namespace deja_view::nerf::internal
