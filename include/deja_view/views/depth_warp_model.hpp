#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/views/scene_model.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace deja_view {

/// The ranges of a real image's pixels, where they are known.
using RangeSource = std::function<std::optional<RangeMap>(std::int64_t stamp_ns)>;

/// The flight's own images as the model of the scene: each is seen from beside it
/// (DepthWarpRenderer), by its known ranges where there are any, by the VIO's points otherwise.
class DepthWarpModel final : public SceneModel {
 public:
  /// `camera` took the images. `ranges` may be empty; `description` tells them from others'.
  DepthWarpModel(std::shared_ptr<const Camera> camera, RangeSource ranges, std::string description);

  /// The images' poses are the frame, whatever they are.
  Similarity3 FindFrame(const std::optional<Similarity3>& told) const override;
  std::shared_ptr<const ViewRenderer> RendererFor(
      const ViewSource& source, const std::vector<RangeSample>& points) const override;
  bool NeedsPoints() const override;
  void Relax(GateOptions* gate) const override;
  std::string Describe() const override;

 private:
  std::shared_ptr<const Camera> camera_;
  RangeSource ranges_;
  std::string description_;
};

}  // namespace deja_view
