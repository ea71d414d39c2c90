#include "plain_field.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/camera/kannala_brandt_camera.hpp"
#include "deja_view/camera/mei_camera.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include <algorithm>
#include <cmath>

#include "ray_tracer.hpp"

namespace deja_view::nerf::internal {
namespace {

constexpr double kLargestRadius = 1e6;  ///< stands for infinity

double RadiusOf(double radius_squared) {
  return std::min(kLargestRadius, std::sqrt(radius_squared));
}

LensView MakeLens(const PinholeCamera& camera) {
  const PinholeParameters& p = camera.parameters();
  LensView lens{LensView::Model::kPinhole, p.fx, p.fy, p.cx, p.cy, 0, {p.k1, p.k2, p.p1, p.p2}};
  lens.limit = RadiusOf(camera.max_radius_squared());
  return lens;
}

LensView MakeLens(const KannalaBrandtCamera& camera) {
  const KannalaBrandtParameters& p = camera.parameters();
  LensView lens{
      LensView::Model::kKannalaBrandt, p.mu, p.mv, p.u0, p.v0, 0, {p.k2, p.k3, p.k4, p.k5}};
  lens.limit = camera.max_theta();
  return lens;
}

LensView MakeLens(const MeiCamera& camera) {
  const MeiParameters& p = camera.parameters();
  LensView lens{
      LensView::Model::kMei, p.gamma1, p.gamma2, p.u0, p.v0, p.xi, {p.k1, p.k2, p.p1, p.p2}};
  lens.limit = RadiusOf(camera.max_radius_squared());
  return lens;
}

FieldLayout::Grid LayoutOf(const FeatureGrid& grid) {
  return {grid.levels(), grid.parameters().size()};
}

}  // namespace

LensView LensOf(const Camera& camera) {
  if (const auto* pinhole = dynamic_cast<const PinholeCamera*>(&camera)) {
    return MakeLens(*pinhole);
  }
  if (const auto* fisheye = dynamic_cast<const KannalaBrandtCamera*>(&camera)) {
    return MakeLens(*fisheye);
  }
  const auto* mei = dynamic_cast<const MeiCamera*>(&camera);
  DEJA_VIEW_CHECK(mei != nullptr);
  return MakeLens(*mei);
}

PlainPose PlainPoseOf(const Rigid3& pose) {
  PlainPose plain;
  const Eigen::Matrix3d R = pose.R();
  for (std::size_t i = 0; i < 9; ++i) {
    plain.R[i] = R(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3));
  }
  std::copy_n(pose.t.data(), 3, plain.t.begin());
  return plain;
}

FieldLayout LayoutOf(const RadianceField& field) {
  FieldLayout layout;
  layout.geometry = LayoutOf(field.geometry);
  layout.appearance = LayoutOf(field.appearance);
  layout.density = field.density.layers();
  layout.color = field.color.layers();
  if (field.options.far_background) {
    layout.background = LayoutOf(field.background);
    layout.background_color = field.background_color.layers();
  }
  layout.channels = field.channels;
  layout.direction_degree = field.options.direction_degree;
  layout.latent_size = field.options.latent_size;
  layout.occupancy = field.occupancy.view();
  layout.box = ViewOf(field.box);
  return layout;
}

DeviceEngine::ConstArrays ArraysOf(const RadianceField& field) {
  return {field.geometry.parameters().data(),
          field.appearance.parameters().data(),
          field.background.parameters().data(),
          field.density.parameters().data(),
          field.color.parameters().data(),
          field.background_color.parameters().data(),
          field.occupancy.words().data()};
}

DeviceEngine::Arrays ArraysOf(RadianceField* field, std::vector<std::uint64_t>* words) {
  words->resize(field->occupancy.words().size());
  return {field->geometry.parameters().data(),
          field->appearance.parameters().data(),
          field->background.parameters().data(),
          field->density.parameters().data(),
          field->color.parameters().data(),
          field->background_color.parameters().data(),
          words->data()};
}

std::size_t BytesOf(const RadianceField& field) {
  const std::size_t values =
      field.geometry.parameters().size() + field.appearance.parameters().size() +
      field.background.parameters().size() + field.density.parameters().size() +
      field.color.parameters().size() + field.background_color.parameters().size();
  return values * sizeof(float) + field.occupancy.words().size() * (sizeof(std::uint64_t) + 2);
}

}  // namespace deja_view::nerf::internal
