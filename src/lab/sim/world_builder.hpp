#pragma once

#include "deja_view/lab/sim/light_source.hpp"
#include "deja_view/lab/sim/obstacle.hpp"
#include "deja_view/lab/sim/options.hpp"
#include "deja_view/lab/sim/random.hpp"
#include "deja_view/lab/sim/scene.hpp"

#include <cstdint>
#include <vector>

namespace deja_view::sim {

/// Furnishes a hall. One use: construct, then Build.
class WorldBuilder {
 public:
  WorldBuilder(std::uint64_t seed, const WorldOptions& options, int threads);

  void Build(Scene* scene, std::vector<Obstacle>* obstacles, std::vector<LightSource>* lamps);

 private:
  /// One of the four walls: its lower left corner as seen from inside and its direction.
  struct Wall {
    Eigen::Vector3f corner, along;
    float length;
  };

  void MakeTextures();
  int PickTexture(Material material);
  /// Adds a surface whose texture repeats every `period` metres (0: once over the surface).
  Surface& AddSurface(const Surface& shape, Material material, float period);
  void AddRectangle(const Eigen::Vector3f& origin,
                    const Eigen::Vector3f& u,
                    const Eigen::Vector3f& v,
                    Material material,
                    float period);
  void AddBox(const Obstacle& box, Material sides, float period);
  void AddCylinder(const Eigen::Vector3f& base,
                   const Eigen::Vector3f& axis,
                   float radius,
                   float height,
                   Material material,
                   float period);
  void AddRoom();
  void AddLamps();
  void AddWindows();
  void AddPipes();
  void AddPosters();
  void AddDarkPanels();
  void AddFurniture();
  void PlaceFurniture(const Obstacle& piece);
  Obstacle DrawFurniture();
  double DistanceToLane(const Obstacle& piece) const;
  bool IsFree(const Obstacle& piece) const;
  const Wall& AnyWall() { return walls_[static_cast<std::size_t>(rng_.Index(4))]; }

  std::uint64_t seed_;
  WorldOptions options_;
  int threads_;
  Rng rng_;
  std::vector<Wall> walls_;
  std::vector<std::vector<int>> textures_of_;  ///< by Material
  Scene* scene_ = nullptr;
  std::vector<Obstacle>* obstacles_ = nullptr;
  std::vector<LightSource>* lamps_ = nullptr;
};

}  // namespace deja_view::sim
