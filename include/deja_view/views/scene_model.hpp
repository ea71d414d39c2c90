#pragma once

#include "deja_view/geometry/alignment.hpp"
#include "deja_view/views/depth_warp_renderer.hpp"
#include "deja_view/views/scene_cells.hpp"
#include "deja_view/views/view_gate.hpp"
#include "deja_view/views/view_maker.hpp"
#include "deja_view/views/view_renderer.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace deja_view {

/// How an image shows a scene: displayed = gain * radiance + bias.
struct SceneExposure {
  float gain = 1;
  float bias = 0;  ///< in units of white
};

/// The renderer of what is beside one real image; `points` are those that the VIO tracks in it.
/// Called by several threads.
using ViewRendererFactory = std::function<std::shared_ptr<const ViewRenderer>(
    const ViewSource& source, const std::vector<RangeSample>& points)>;

/// A known scene in its own frame N: all that nodes and tools know of what renders. OpenSceneModel
/// (scene) opens one; a new way to render is a class of this and a line there. Safe to call from
/// several threads.
class SceneModel {
 public:
  virtual ~SceneModel() = default;

  /// W_N, with W the world of poses in metres. `told` is what the poses themselves say where they
  /// are those that the model was made of. Throws InputError that names the model and the way out
  /// where nobody knows.
  virtual Similarity3 FindFrame(const std::optional<Similarity3>& told) const = 0;

  /// See ViewRendererFactory, all of it in N. Throws InputError for a file that can't be read.
  virtual std::shared_ptr<const ViewRenderer> RendererFor(
      const ViewSource& source, const std::vector<RangeSample>& points) const = 0;

  /// Whether it is by the VIO's points that it works.
  virtual bool NeedsPoints() const { return false; }

  /// Of an image of this time; neutral where nobody knows.
  virtual SceneExposure ExposureAt(std::int64_t /*stamp_ns*/) const { return {}; }

  /// Which part of the scene this is the model of.
  virtual SceneCells cells() const { return {}; }

  /// Relaxes what is asked of views to what such a model can know.
  virtual void Relax(GateOptions* /*gate*/) const {}

  /// Lines that tell this model from others.
  virtual std::string Describe() const = 0;
};

/// The model's renderers, of sources and points in W.
ViewRendererFactory RenderersInWorld(std::shared_ptr<const SceneModel> model,
                                     const Similarity3& W_N);

}  // namespace deja_view
