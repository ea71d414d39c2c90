#include "world_builder.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/parallel.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace deja_view::sim {
namespace {

using Eigen::Vector3f;

constexpr double kLane = 0.58;  // semi-axes of the lane over those of the hall

/// How many different textures of each material a hall has without repetition.
constexpr std::array<int, 9> kTextureCounts = {3, 2, 2, 3, 4, 14, 8, 2, 2};

Vector3f Float(const Eigen::Vector3d& v) {
  return v.cast<float>();
}

}  // namespace

WorldBuilder::WorldBuilder(std::uint64_t seed, const WorldOptions& options, int threads)
    : seed_(seed), options_(options), threads_(threads), rng_(seed, 1) {
  const auto x = static_cast<float>(options.length_m);
  const auto y = static_cast<float>(options.width_m);
  walls_ = {{{0, y, 0}, Vector3f::UnitX(), x},
            {{x, y, 0}, -Vector3f::UnitY(), y},
            {{x, 0, 0}, -Vector3f::UnitX(), x},
            {{0, 0, 0}, Vector3f::UnitY(), y}};
}

void WorldBuilder::Build(Scene* scene,
                         std::vector<Obstacle>* obstacles,
                         std::vector<LightSource>* lamps) {
  scene_ = scene;
  obstacles_ = obstacles;
  lamps_ = lamps;
  MakeTextures();
  AddRoom();
  AddLamps();
  AddWindows();
  AddPipes();
  AddPosters();
  AddDarkPanels();
  AddFurniture();
}

void WorldBuilder::MakeTextures() {
  struct Job {
    Material material;
    std::uint64_t stream;
  };
  std::vector<Job> jobs;
  textures_of_.resize(kTextureCounts.size());
  for (std::size_t m = 0; m < kTextureCounts.size(); ++m) {
    if (static_cast<Material>(m) == Material::kLacquer && options_.dark_share == 0) {
      continue;
    }
    const double distinct = kTextureCounts[m] * (1.0 - options_.repetition);
    const int count = std::max(1, static_cast<int>(std::lround(distinct)));
    for (int i = 0; i < count; ++i) {
      textures_of_[m].push_back(static_cast<int>(jobs.size()));
      jobs.push_back({static_cast<Material>(m), 1000 + 100 * m + static_cast<std::uint64_t>(i)});
    }
  }
  std::vector<std::vector<Texture>> made(jobs.size());
  ParallelFor(threads_, jobs.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      made[i].push_back(MakeTexture(jobs[i].material,
                                    options_.texture_size_px,
                                    options_.texture_strength,
                                    Rng(seed_, jobs[i].stream)));
    }
  });
  for (auto& texture : made) {
    scene_->textures.push_back(std::move(texture.front()));
  }
}

int WorldBuilder::PickTexture(Material material) {
  const auto& choice = textures_of_[static_cast<std::size_t>(material)];
  return choice[static_cast<std::size_t>(rng_.Index(static_cast<int>(choice.size())))];
}

Surface& WorldBuilder::AddSurface(const Surface& shape, Material material, float period) {
  Surface surface = shape;
  surface.texture = PickTexture(material);
  surface.gloss = material == Material::kLacquer ? 0.05F : 0.0F;  // as glass
  surface.period =
      period > 0 ? Eigen::Vector2f(period, period) : Eigen::Vector2f(shape.size_u, shape.size_v);
  if (period > 0 && !rng_.Chance(options_.repetition)) {
    surface.texture_origin = {static_cast<float>(rng_.Uniform()),
                              static_cast<float>(rng_.Uniform())};
  }
  return scene_->surfaces.emplace_back(surface);
}

void WorldBuilder::AddRectangle(
    const Vector3f& origin, const Vector3f& u, const Vector3f& v, Material material, float period) {
  Surface shape;
  shape.origin = origin;
  shape.size_u = u.norm();
  shape.size_v = v.norm();
  shape.axis_u = u / shape.size_u;
  shape.axis_v = v / shape.size_v;
  AddSurface(shape, material, period);
}

void WorldBuilder::AddBox(const Obstacle& box, Material sides, float period) {
  const auto yaw = static_cast<float>(box.yaw);
  const Vector3f half = Float(box.half_size);
  const Vector3f x = 2 * half.x() * Vector3f(std::cos(yaw), std::sin(yaw), 0);
  const Vector3f y = 2 * half.y() * Vector3f(-std::sin(yaw), std::cos(yaw), 0);
  const Vector3f z(0, 0, 2 * half.z());
  const Vector3f o = Float(box.centre) - 0.5F * (x + y + z);
  AddRectangle(o, x, z, sides, period);
  AddRectangle(o + x, y, z, sides, period);
  AddRectangle(o + x + y, -x, z, sides, period);
  AddRectangle(o + y, -y, z, sides, period);
  AddRectangle(o + z, x, y, Material::kPlanks, 1.6F);
  if (o.z() > 0.02F) {
    AddRectangle(o + y, x, -y, Material::kPlanks, 1.6F);
  }
}

void WorldBuilder::AddCylinder(const Vector3f& base,
                               const Vector3f& axis,
                               float radius,
                               float height,
                               Material material,
                               float period) {
  Surface shape;
  shape.shape = Shape::kCylinder;
  shape.origin = base;
  shape.axis_v = axis;
  shape.axis_u = axis.unitOrthogonal();
  shape.size_u = 6.2831853F * radius;
  shape.size_v = height;
  Surface& mantle = AddSurface(shape, material, period);
  // A whole number of periods around, so that there is no seam.
  mantle.period.x() = shape.size_u / std::max(1.0F, std::round(shape.size_u / period));
}

void WorldBuilder::AddRoom() {
  const Vector3f x(static_cast<float>(options_.length_m), 0, 0);
  const Vector3f y(0, static_cast<float>(options_.width_m), 0);
  const Vector3f z(0, 0, static_cast<float>(options_.height_m));
  const Material floor = options_.dark_share > 0 ? Material::kLacquer : Material::kConcrete;
  AddRectangle(Vector3f::Zero(), x, y, floor, 3.1F);
  AddRectangle(z + y, x, -y, Material::kPlaster, 2.4F);
  const std::array<Material, 4> walls = {
      Material::kBrick, Material::kPlaster, Material::kBrick, Material::kConcrete};
  const int turn = rng_.Index(4);
  for (std::size_t i = 0; i < walls_.size(); ++i) {
    const Wall& wall = walls_[i];
    const Material material = walls[(i + static_cast<std::size_t>(turn)) % walls.size()];
    AddRectangle(wall.corner,
                 wall.length * wall.along,
                 z,
                 material,
                 static_cast<float>(rng_.Uniform(2.4, 3.4)));
  }
}

void WorldBuilder::AddLamps() {
  const auto height = static_cast<float>(options_.height_m);
  const int columns = std::max(1, static_cast<int>(options_.length_m / 3.6));
  const int rows = std::max(1, static_cast<int>(options_.width_m / 3.6));
  for (int i = 0; i < columns * rows; ++i) {
    const float x = static_cast<float>(options_.length_m * (i % columns + 0.5) / columns);
    const float y = static_cast<float>(options_.width_m * (i / columns + 0.5) / rows);
    const float z = height - 0.3F;
    AddRectangle({x - 0.6F, y + 0.1F, z}, {1.2F, 0, 0}, {0, -0.2F, 0}, Material::kPlaster, 0);
    scene_->surfaces.back().emission = 6.0F;
    LightSource lamp;
    lamp.points = {{x - 0.3F, y, z - 0.03F}, {x + 0.3F, y, z - 0.03F}};
    lamp.intensity = static_cast<float>(rng_.Uniform(2.2, 4.4));
    lamps_->push_back(lamp);
  }
}

void WorldBuilder::AddWindows() {
  for (int i = 0; i < options_.windows; ++i) {
    const Wall& wall = AnyWall();
    const auto width = static_cast<float>(rng_.Uniform(1.0, 2.0));
    const auto height = static_cast<float>(rng_.Uniform(0.8, 1.3));
    const Vector3f inwards = wall.along.cross(Vector3f::UnitZ());
    const auto left = static_cast<float>(rng_.Uniform(0.3, wall.length - width - 0.3));
    const auto low =
        static_cast<float>(rng_.Uniform(1.2, std::max(1.3, options_.height_m - height - 0.8)));
    const Vector3f corner = wall.corner + left * wall.along + low * Vector3f::UnitZ();
    AddRectangle(
        corner + 0.04F * inwards, width * wall.along, {0, 0, height}, Material::kPlaster, 0);
    scene_->surfaces.back().emission = static_cast<float>(options_.window_radiance);
    LightSource light;
    light.normal = inwards;
    light.intensity = static_cast<float>(0.35 * options_.window_radiance) * width * height;
    for (const float share : {0.25F, 0.75F}) {
      light.points.emplace_back(corner + share * width * wall.along + Vector3f(0, 0, height / 2) +
                                0.06F * inwards);
    }
    lamps_->push_back(light);
  }
}

void WorldBuilder::AddPipes() {
  const auto height = static_cast<float>(options_.height_m);
  for (float x = 1.3F; x < static_cast<float>(options_.length_m); x += 3.1F) {
    AddCylinder({x, 0, height - 0.55F},
                Vector3f::UnitY(),
                0.09F,
                static_cast<float>(options_.width_m),
                Material::kPanels,
                0.8F);
  }
  for (const Wall& wall : walls_) {
    const Vector3f inwards = wall.along.cross(Vector3f::UnitZ());
    for (float at = 1.6F; at < wall.length; at += 4.3F) {
      const Vector3f foot = wall.corner + at * wall.along + 0.3F * inwards;
      const auto radius = static_cast<float>(rng_.Uniform(0.1, 0.18));
      AddCylinder(foot, Vector3f::UnitZ(), radius, height, Material::kPanels, 0.9F);
      Obstacle pipe;
      pipe.centre = foot.cast<double>() + Eigen::Vector3d(0, 0, options_.height_m / 2);
      pipe.half_size = {radius, radius, options_.height_m / 2};
      pipe.is_cylinder = true;
      obstacles_->push_back(pipe);
    }
  }
}

void WorldBuilder::AddPosters() {
  for (int i = 0; i < options_.posters; ++i) {
    const Wall& wall = walls_[static_cast<std::size_t>(i) % 4];
    const bool on_lattice = rng_.Chance(options_.repetition);
    const auto width = static_cast<float>(on_lattice ? 0.8 : rng_.Uniform(0.35, 1.2));
    const auto height = static_cast<float>(on_lattice ? 1.0 : width * rng_.Uniform(0.7, 1.4));
    // On the lattice every second metre has the same poster at the same height.
    const float left =
        on_lattice ? 0.5F + 2.0F * static_cast<float>(rng_.Index(static_cast<int>(wall.length / 2)))
                   : static_cast<float>(rng_.Uniform(0.05, wall.length - width - 0.05));
    const float low = on_lattice ? 1.4F
                                 : static_cast<float>(rng_.Uniform(
                                       0.5, std::max(0.6, 0.8 * options_.height_m - height)));
    const Vector3f inwards = wall.along.cross(Vector3f::UnitZ());
    // Each its own distance from the wall, so that overlapping posters do not fight for the ray.
    const float lift = 0.01F + 0.0005F * static_cast<float>(i);
    AddRectangle(wall.corner + left * wall.along + low * Vector3f::UnitZ() + lift * inwards,
                 width * wall.along,
                 {0, 0, height},
                 rng_.Chance(0.8) ? Material::kPoster : Material::kPanels,
                 0);
  }
  for (int i = 0; i < 6; ++i) {
    const double side = rng_.Uniform(0.8, 2.0);
    const double yaw = rng_.Uniform(0, 3.14);
    const Vector3f u =
        static_cast<float>(side) *
        Vector3f(std::cos(static_cast<float>(yaw)), std::sin(static_cast<float>(yaw)), 0);
    const Vector3f v = Vector3f::UnitZ().cross(u);
    const Vector3f centre(static_cast<float>(rng_.Uniform(side, options_.length_m - side)),
                          static_cast<float>(rng_.Uniform(side, options_.width_m - side)),
                          0.004F + 0.001F * static_cast<float>(i));
    AddRectangle(centre - 0.5F * (u + v), u, v, Material::kCamouflage, 1.4F);
  }
}

/// Doors and screens in turn.
void WorldBuilder::AddDarkPanels() {
  const int count = static_cast<int>(std::lround(options_.dark_share * 20));
  for (int i = 0; i < count; ++i) {
    const Wall& wall = walls_[static_cast<std::size_t>(i / 2) % 4];
    const bool is_door = i % 2 == 0;
    const float width = is_door ? 1.0F : 1.3F;
    const float low = is_door ? 0.0F : static_cast<float>(rng_.Uniform(0.9, 1.3));
    const auto left = static_cast<float>(rng_.Uniform(0.05, wall.length - width - 0.05));
    // Before posters and windows.
    const float lift = 0.05F + 0.0005F * static_cast<float>(i);
    const Vector3f inwards = wall.along.cross(Vector3f::UnitZ());
    AddRectangle(wall.corner + left * wall.along + low * Vector3f::UnitZ() + lift * inwards,
                 width * wall.along,
                 {0, 0, is_door ? 2.1F : 0.8F},
                 Material::kLacquer,
                 0);
  }
}

Obstacle WorldBuilder::DrawFurniture() {
  Obstacle piece;
  const double x = options_.length_m;
  const double y = options_.width_m;
  piece.is_cylinder = rng_.Chance(0.25);
  piece.half_size = {rng_.Uniform(0.15, 0.6), rng_.Uniform(0.15, 0.6), rng_.Uniform(0.2, 1.1)};
  // A small hall has smaller things.
  const double shrink = std::clamp(std::min(x, y) / 12.0, 0.6, 1.0);
  piece.half_size.head<2>() *= shrink;
  const double kind = rng_.Uniform();
  if (kind < 0.5) {  // along a wall, squarely
    const Wall& wall = AnyWall();
    const Vector3f inwards = wall.along.cross(Vector3f::UnitZ());
    const double reach = std::hypot(piece.half_size.x(), piece.half_size.y());
    const double at = rng_.Uniform(reach, wall.length - reach);
    const Vector3f foot = wall.corner + static_cast<float>(at) * wall.along +
                          static_cast<float>(reach + 0.1) * inwards;
    piece.centre = foot.cast<double>();
    piece.yaw = std::atan2(wall.along.y(), wall.along.x());
  } else if (kind < 0.85) {  // the island in the middle
    const double angle = rng_.Uniform(0, 6.2831853);
    const double radius = 0.3 * std::sqrt(rng_.Uniform());
    piece.centre = {
        x * (0.5 + 0.6 * radius * std::cos(angle)), y * (0.5 + 0.6 * radius * std::sin(angle)), 0};
    piece.yaw = rng_.Uniform(0, 3.14);
  } else {  // low things on the lane
    piece.half_size.z() = rng_.Uniform(0.1, 0.22);
    piece.centre = {rng_.Uniform(1.0, x - 1.0), rng_.Uniform(1.0, y - 1.0), 0};
    piece.yaw = rng_.Uniform(0, 3.14);
  }
  if (piece.is_cylinder) {
    piece.half_size.y() = piece.half_size.x();
  }
  piece.centre.z() = piece.half_size.z();
  return piece;
}

/// Distance [m] in the plane to the ellipse in the middle of the free lane.
double WorldBuilder::DistanceToLane(const Obstacle& piece) const {
  const Eigen::Vector2d half(0.5 * options_.length_m, 0.5 * options_.width_m);
  double distance = half.norm();
  for (int i = 0; i < 180; ++i) {
    const double angle = kPi / 90.0 * i;
    const Eigen::Vector2d on_lane(half.x() * (1.0 + kLane * std::cos(angle)),
                                  half.y() * (1.0 + kLane * std::sin(angle)));
    distance = std::min(distance, (piece.centre.head<2>() - on_lane).norm());
  }
  return distance;
}

bool WorldBuilder::IsFree(const Obstacle& piece) const {
  const double reach = std::hypot(piece.half_size.x(), piece.half_size.y());
  const bool is_low = 2 * piece.half_size.z() < 0.5;
  if (!is_low && DistanceToLane(piece) < reach + 0.7) {
    return false;
  }
  return std::all_of(obstacles_->begin(), obstacles_->end(), [&](const Obstacle& other) {
    const double other_reach = other.is_cylinder
                                   ? other.half_size.x()
                                   : std::hypot(other.half_size.x(), other.half_size.y());
    const Eigen::Vector2d gap = (piece.centre - other.centre).head<2>();
    return gap.norm() > reach + other_reach + 0.02;
  });
}

void WorldBuilder::PlaceFurniture(const Obstacle& piece) {
  static constexpr std::array<Material, 6> kSides = {Material::kShelf,
                                                     Material::kPlanks,
                                                     Material::kPanels,
                                                     Material::kPoster,
                                                     Material::kShelf,
                                                     Material::kShelf};
  Material sides = rng_.Chance(options_.repetition)
                       ? Material::kShelf
                       : kSides[static_cast<std::size_t>(rng_.Index(6))];
  if (options_.dark_share > 0 && rng_.Chance(options_.dark_share)) {
    sides = Material::kLacquer;
  }
  if (!piece.is_cylinder) {
    AddBox(piece, sides, 0);
    return;
  }
  const Vector3f base =
      Float(piece.centre) - Vector3f(0, 0, static_cast<float>(piece.half_size.z()));
  const auto radius = static_cast<float>(piece.half_size.x());
  const auto height = static_cast<float>(2 * piece.half_size.z());
  AddCylinder(base, Vector3f::UnitZ(), radius, height, sides, 1.1F);
  Surface lid;
  lid.shape = Shape::kDisc;
  lid.origin = base + Vector3f(-radius, -radius, height);
  lid.size_u = 2 * radius;
  lid.size_v = 2 * radius;
  AddSurface(lid, Material::kPanels, 1.0F);
}

void WorldBuilder::AddFurniture() {
  int placed = 0;
  for (int attempt = 0; attempt < 60 * options_.furniture && placed < options_.furniture;
       ++attempt) {
    const Obstacle piece = DrawFurniture();
    if (IsFree(piece)) {
      PlaceFurniture(piece);
      obstacles_->push_back(piece);
      ++placed;
    }
  }
}

}  // namespace deja_view::sim
