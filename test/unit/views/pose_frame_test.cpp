#include "deja_view/views/pose_frame.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include <cmath>
#include <random>

#include "room_renderer.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

using ::testing::HasSubstr;

Trajectory Flight() {
  Trajectory flight;
  for (int i = 0; i < 60; ++i) {
    const double t = 0.1 * i;
    flight.stamps_ns.push_back(1'000'000'000 + i * 100'000'000LL);
    flight.poses.push_back({ExpSo3({0.1 * std::sin(t), 0.2, 0.3 * t}),
                            {2 * std::sin(t), std::cos(0.8 * t), 0.3 * std::sin(2 * t)}});
  }
  return flight;
}

// As structure from motion has it, N: p_W = 2.5 R p_N + t.
const Similarity3 kW_N{2.5, {ExpSo3({0.4, -1.2, 2}), {3, -1, 0.5}}};

Trajectory InModelFrame(const Trajectory& T_W_C, double noise) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, noise);
  Trajectory T_N_C = T_W_C;
  for (Rigid3& pose : T_N_C.poses) {
    pose = kW_N.T_A_B.Inverse() * pose;
    pose.t =
        (pose.t + Eigen::Vector3d(normal(random), normal(random), normal(random))) / kW_N.scale;
  }
  return T_N_C;
}

std::string ErrorOf(const Trajectory& T_N_C,
                    bool has_scale,
                    const std::optional<Trajectory>& vio,
                    const PoseFitOptions& options = {}) {
  try {
    FindPoseFrame(T_N_C, has_scale, vio, options, "colmap/sparse");
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(PoseFrameTest, GivesScaleAndFrameToStructureFromMotion) {
  const Trajectory vio = Flight();
  const PoseFrame frame = FindPoseFrame(InModelFrame(vio, 0.01), false, vio, {}, "model");
  EXPECT_NEAR(frame.W_N.scale, 2.5, 0.02);
  EXPECT_LT(RotationAngle(frame.W_N.T_A_B.q.conjugate() * kW_N.T_A_B.q), 0.01);
  EXPECT_LT((frame.W_N.T_A_B.t - kW_N.T_A_B.t).norm(), 0.03);
  ASSERT_TRUE(frame.fit.has_value());
  EXPECT_NEAR(frame.fit->rmse_m, 0.01 * std::sqrt(3), 0.006);
}

TEST(PoseFrameTest, LeavesPosesWithAScaleWhereTheyAre) {
  const Trajectory vio = Flight();
  const Trajectory truth = Transform({1, {FromYaw(2), {5, 6, 7}}}, vio);
  const PoseFrame frame = FindPoseFrame(truth, true, vio, {}, "truth.txt");
  EXPECT_EQ(frame.W_N.scale, 1);
  EXPECT_EQ(frame.W_N.T_A_B.t.norm(), 0);
  ASSERT_TRUE(frame.fit.has_value());
  EXPECT_LT(frame.fit->rmse_m, 1e-9);
  EXPECT_LT(frame.fit->rotation_rad, 1e-6);
}

TEST(PoseFrameTest, RefusesPosesOfAnotherFlight) {
  const Trajectory vio = Flight();
  EXPECT_THAT(ErrorOf(InModelFrame(vio, 0), true, vio), HasSubstr("colmap/sparse: does not fit"));
  EXPECT_THAT(ErrorOf(InModelFrame(vio, 0.1), false, vio), HasSubstr("no error"));
  PoseFitOptions strict;
  strict.max_rmse_m = 0.05;
  EXPECT_THAT(ErrorOf(InModelFrame(vio, 0.1), false, vio, strict), HasSubstr("at most 0.05 m"));
}

TEST(PoseFrameTest, ChecksNothingWithoutEnoughOfAVio) {
  const Trajectory flight = Flight();
  const PoseFrame alone = FindPoseFrame(flight, true, std::nullopt, {}, "truth.txt");
  EXPECT_FALSE(alone.fit.has_value());
  EXPECT_THAT(alone.not_checked, HasSubstr("no poses of a VIO"));
  Trajectory few = flight;
  few.stamps_ns.resize(5);
  few.poses.resize(5);
  const PoseFrame little = FindPoseFrame(flight, true, few, {}, "truth.txt");
  EXPECT_FALSE(little.fit.has_value());
  EXPECT_THAT(little.not_checked, HasSubstr("5 poses"));
  // A scale has to come from somewhere.
  EXPECT_THAT(ErrorOf(flight, false, std::nullopt), HasSubstr("without a scale"));
  EXPECT_THAT(ErrorOf(flight, false, few), HasSubstr("5 poses"));
}

TEST(PoseFrameTest, OptionsListAllViolations) {
  PoseFitOptions options;
  options.inlier_distance_m = 0;
  options.max_rmse_m = -1;
  options.min_inlier_share = 2;
  options.max_rotation_deg = 200;
  EXPECT_EQ(options.Validate().size(), 4U);
  EXPECT_TRUE(PoseFitOptions().Validate().empty());
}

// The room, with all lengths 2.5 times smaller.
class SmallRoom final : public RoomRenderer {
 public:
  RenderedView Render(const Camera& camera,
                      const Rigid3& T_N_C,
                      const ViewRenderOptions& options) const override {
    const Rigid3 T_W_C{T_N_C.q, 2.5 * T_N_C.t};
    RenderedView view = RoomRenderer::Render(camera, T_W_C, options);
    view.depth /= 2.5;
    view.depth_variance /= 2.5 * 2.5;
    return view;
  }
};

TEST(SimilarityRendererTest, ShowsAModelOfAnotherScaleInMetres) {
  const PinholeCamera camera({160, 120, 100, 100, 79.5, 59.5, 0, 0, 0, 0});
  const Rigid3 T_W_N{ExpSo3({0.3, 0.1, -0.8}), {4, 5, 6}};
  const Rigid3 T_room_C{ExpSo3({0.1, 0.4, 0}), {0.5, -0.3, 0.2}};
  const SimilarityRenderer renderer(std::make_shared<SmallRoom>(), {2.5, T_W_N});
  const RenderedView view = renderer.Render(camera, T_W_N * T_room_C, {0.9F, 0.05F, 1});
  const RenderedView truth = RoomRenderer().Render(camera, T_room_C, {0.9F, 0.05F, 1});
  // Rounding may move the edge of a pattern across a pixel's centre.
  EXPECT_LE(cv::countNonZero(view.image != truth.image), 20);
  EXPECT_LT(cv::norm(view.depth, truth.depth, cv::NORM_INF), 1e-4);
  EXPECT_LT(cv::norm(view.depth_variance, truth.depth_variance, cv::NORM_INF), 1e-4);
  EXPECT_THROW(SimilarityRenderer(std::make_shared<SmallRoom>(), {0, {}}), CheckError);
  const RenderedView placed = PlaceInWorld(std::make_shared<SmallRoom>(), {2.5, T_W_N})
                                  ->Render(camera, T_W_N * T_room_C, {});
  EXPECT_LT(cv::norm(placed.depth, truth.depth, cv::NORM_INF), 1e-4);
}

TEST(SimilarityRendererTest, ModelsInTheWorldStayAsTheyAre) {
  const auto room = std::make_shared<RoomRenderer>();
  EXPECT_EQ(PlaceInWorld(room, {}), room);
  EXPECT_NE(PlaceInWorld(room, {1, {FromYaw(0.1), {0, 0, 0}}}), room);
}

}  // namespace
}  // namespace deja_view
