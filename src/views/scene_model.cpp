#include "deja_view/views/scene_model.hpp"

#include "deja_view/views/pose_frame.hpp"

#include <utility>

namespace deja_view {

ViewRendererFactory RenderersInWorld(std::shared_ptr<const SceneModel> model,
                                     const Similarity3& W_N) {
  return [model = std::move(model), W_N](ViewSource source, std::vector<RangeSample> points) {
    source.T_N_C = CameraInFrame(W_N, source.T_N_C);
    for (RangeSample& point : points) {
      point.range_m /= W_N.scale;
    }
    return PlaceInWorld(model->RendererFor(source, points), W_N);
  };
}

}  // namespace deja_view
