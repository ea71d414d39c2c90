#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/lab/sim/beam_caster.hpp"
#include "deja_view/lab/sim/shader.hpp"
#include "deja_view/lab/sim/world.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace deja_view::sim {

/// Casts rays through every pixel of a real camera model into a hall. The camera's rays are
/// computed once. Const methods may be called from several threads.
class Renderer {
 public:
  /// `samples`: rays per pixel, 1 to 64, each at another place within the pixel. `threads` 0: all
  /// cores.
  Renderer(std::shared_ptr<const World> world,
           std::shared_ptr<const Camera> camera,
           int samples = 4,
           int threads = 0);

  const World& world() const { return *world_; }
  const Camera& camera() const { return *camera_; }
  int samples() const { return samples_; }

  /// Linear radiance (CV_32FC1, height x width), the mean over `samples` rays per pixel; all at one
  /// pose.
  cv::Mat RenderRadiance(const Rigid3& T_W_C) const;

  /// The same with ray i of every pixel cast from pose i (motion blur). One pose per sample.
  cv::Mat RenderRadiance(const std::vector<Rigid3>& T_W_C) const;

  /// Exact distance [m] along the unit ray through each pixel's centre (CV_32FC1): the point is
  /// `T_W_C * (range * camera.Unproject(pixel))`. Infinite where nothing is hit.
  cv::Mat RenderRange(const Rigid3& T_W_C) const;

 private:
  static constexpr int kTile = 16;
  static constexpr int kBlock = 4;  ///< tiles per side of a block, which is culled first

  /// A rectangle of pixels and the cone about its rays.
  struct Beam {
    int x = 0, y = 0;  ///< [px] top left
    int width = 0, height = 0;
    Cone cone;
  };
  struct Tile {
    Beam beam;
    std::size_t first_row = 0;  ///< its place in a RayTable
  };
  struct Block {
    Beam beam;
    std::vector<Tile> tiles;
  };
  /// Unit rays in C of one row of a tile.
  struct alignas(64) RayRow {
    std::array<float, kTile> x, y, z;
  };
  /// The rows of all tiles, in the order in which they are traced.
  using RayTable = std::vector<RayRow>;

  Beam MakeBeam(int x, int y, int size) const;
  void MakeBlocks();
  /// Rays through all pixels, `offset` [px] off their centres.
  RayTable MakeRays(const Eigen::Vector2d& offset) const;
  template <typename Row>
  void TraceBlock(const BeamCaster& caster,
                  const Block& block,
                  const RayTable& rays,
                  const Row& row) const;

  std::shared_ptr<const World> world_;
  std::shared_ptr<const Camera> camera_;
  int samples_;
  int threads_;
  std::unique_ptr<const Shader> shader_;
  std::vector<RayTable> sample_rays_;
  RayTable centre_rays_;
  std::vector<Block> blocks_;
  std::size_t row_count_ = 0;
};

/// A virtual photograph with its exact geometry.
struct View {
  cv::Mat image;  ///< CV_8UC1
  cv::Mat range;  ///< CV_32FC1 [m] along the unit ray
};

/// `radiance` (CV_32FC1) as an image (CV_8UC1): grey = 255 (gain radiance)^(1 / gamma), clipped.
cv::Mat ToneMap(const cv::Mat& radiance, double gain, double gamma = 1.7);

/// Renders what `renderer`'s camera sees from T_W_C without blur, noise or vignetting, at exposure
/// `gain` and display gamma `gamma`.
View RenderView(const Renderer& renderer, const Rigid3& T_W_C, double gain, double gamma = 1.7);

}  // namespace deja_view::sim
