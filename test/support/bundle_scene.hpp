#pragma once

#include "deja_view/base/angles.hpp"
#include "deja_view/base/random.hpp"
#include "deja_view/bundle/bundle_priors.hpp"
#include "deja_view/bundle/bundle_problem.hpp"
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/geometry/alignment.hpp"

#include <cmath>
#include <memory>
#include <vector>

namespace deja_view::test {

struct BundleSceneOptions {
  enum class Motion { kTwoRounds, kTurn, kStand };
  Motion motion = Motion::kTwoRounds;
  int images = 60;
  int points = 900;             ///< on the walls of a room of 8 x 6 x 4 m
  double pixel_noise = 0.3;     ///< [px] per axis
  double wrong_share = 0.03;    ///< keypoints with another point's descriptor
  double step_noise_m = 0.004;  ///< of the odometry, per image and axis
  double yaw_noise_deg = 0.1;   ///< of the odometry, per image
  double time_offset_s = 0;     ///< of the camera against the stamps
  bool has_tracks = false;      ///< the VIO tracks every third point
  std::uint64_t seed = 1;
};

inline BundleSceneOptions SceneOf(int images, int points) {
  BundleSceneOptions options;
  options.images = images;
  options.points = points;
  return options;
}

/// A flight twice round a room, its images' corners, and an odometry that drifts.
struct BundleScene {
  BundleProblem problem;      ///< at the odometry's poses, without priors
  std::vector<Rigid3> T_W_B;  ///< true, at the stamps
  std::vector<Rigid3> T_vio;  ///< the odometry's
  std::vector<std::vector<int>> point_of_keypoint;
  std::vector<Eigen::Vector3d> points;

  void AddOdometryPriors() {
    deja_view::AddOdometryPriors({}, T_vio, std::vector<int>(T_vio.size(), 0), &problem);
  }
  void AddPosePriors(const BundlePriorOptions& options = {}) {
    deja_view::AddPosePriors(options, &problem);
  }

  /// [m] of the bodies after rigid alignment.
  double Rmse() const {
    std::vector<Eigen::Vector3d> truth;
    std::vector<Eigen::Vector3d> estimate;
    for (std::size_t i = 0; i < T_W_B.size(); ++i) {
      truth.push_back(T_W_B[i].t);
      estimate.push_back(problem.images[i].T_W_B.t);
    }
    const Similarity3 A_B = AlignPoints(truth, estimate);
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      sum += (truth[i] - A_B * estimate[i]).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(truth.size()));
  }
};

inline PinholeParameters BundleLens() {
  return {640, 480, 420, 418, 322, 243, -0.12, 0.04, 0.0005, 0};
}

class BundleSceneMaker {
 public:
  explicit BundleSceneMaker(const BundleSceneOptions& options)
      : options_(options), random_(options.seed) {}

  BundleScene Make() {
    BundleScene scene;
    const Rigid3 T_B_C{ExpSo3({0.1, -0.2, 1.5}), {0.05, -0.02, 0.03}};
    scene.problem.cameras.push_back({std::make_shared<PinholeCamera>(BundleLens()), T_B_C, 0.0});
    std::vector<Descriptor> descriptors;
    for (int i = 0; i < options_.points; ++i) {
      scene.points.push_back(OnWall());
      descriptors.push_back(RandomDescriptor());
    }
    for (int i = 0; i < options_.images; ++i) {
      scene.T_W_B.push_back(CameraPose(Phase(i, 0)) * T_B_C.Inverse());
      Drift(scene.T_W_B, &scene.T_vio);
      AddImage(i, CameraPose(Phase(i, options_.time_offset_s)), descriptors, &scene);
    }
    return scene;
  }

 private:
  static constexpr double kInterval_s = 0.4;

  double Normal() {
    const double radius = std::sqrt(-2 * std::log(1 - random_.Uniform()));
    return radius * std::cos(2 * kPi * random_.Uniform());
  }

  Eigen::Vector3d OnWall() {
    Eigen::Vector3d p(random_.Uniform(-4, 4), random_.Uniform(-3, 3), random_.Uniform(-2, 2));
    if (random_.Uniform() < 0.5) {
      p.x() = p.x() < 0 ? -4 : 4;
    } else {
      p.y() = p.y() < 0 ? -3 : 3;
    }
    return p;
  }

  Descriptor RandomDescriptor() {
    Descriptor descriptor;
    for (std::uint64_t& word : descriptor.words) {
      word = random_.Next();
    }
    return descriptor;
  }

  /// Angle on the way round [rad] when image `i` is taken.
  double Phase(int i, double offset_s) const {
    return 4 * kPi * (i + offset_s / kInterval_s) / options_.images;
  }

  Rigid3 CameraPose(double phase) const {
    using Motion = BundleSceneOptions::Motion;
    const double yaw = options_.motion == Motion::kStand ? 0.3 : phase;
    Eigen::Matrix3d R;  // looks outwards
    R.col(0) = Eigen::Vector3d(std::sin(yaw), -std::cos(yaw), 0);
    R.col(1) = -Eigen::Vector3d::UnitZ();
    R.col(2) = Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0);
    const double a = options_.motion == Motion::kTwoRounds ? phase : 0;
    const Eigen::Quaterniond nod = ExpSo3({0.1 * std::sin(5 * a), 0, 0.05 * std::cos(3 * a)});
    return {Eigen::Quaterniond(R) * nod,
            {1.5 * std::cos(a), 1.2 * std::sin(a), 0.4 * std::sin(2.5 * a)}};
  }

  void Drift(const std::vector<Rigid3>& truth, std::vector<Rigid3>* vio) {
    const Rigid3& T = truth.back();
    if (vio->empty()) {
      vio->push_back(T);
      return;
    }
    yaw_ += options_.yaw_noise_deg * kDegree * Normal();
    const Eigen::Vector3d step = T.t - truth[truth.size() - 2].t;
    const double x = Normal();
    const double y = Normal();
    const Eigen::Vector3d noise = options_.step_noise_m * Eigen::Vector3d(x, y, Normal());
    vio->push_back({FromYaw(yaw_) * T.q, vio->back().t + FromYaw(yaw_) * step + noise});
  }

  void AddImage(int i,
                const Rigid3& T_W_C,
                const std::vector<Descriptor>& descriptors,
                BundleScene* scene) {
    BundleImage image;
    image.stamp_ns = std::llround(1e9 * kInterval_s * i);
    image.T_W_B = scene->T_vio.back();
    std::vector<int> seen;
    const Camera& camera = *scene->problem.cameras.front().camera;
    for (int p = 0; p < options_.points; ++p) {
      const auto point = static_cast<std::size_t>(p);
      const auto pixel = camera.Project(T_W_C.Inverse() * scene->points[point]);
      if (!pixel || !camera.IsInImage(*pixel, 2)) {
        continue;
      }
      const double x = Normal();
      const Eigen::Vector2d noise = options_.pixel_noise * Eigen::Vector2d(x, Normal());
      const bool is_wrong = random_.Uniform() < options_.wrong_share;
      Descriptor descriptor =
          is_wrong ? descriptors[random_.Below(descriptors.size())] : descriptors[point];
      for (int bit = 0; bit < 8; ++bit) {
        descriptor.words[random_.Below(4)] ^= std::uint64_t{1} << random_.Below(64);
      }
      image.keypoints.push_back((*pixel + noise).cast<float>());
      image.descriptors.push_back(descriptor);
      image.track_ids.push_back(options_.has_tracks && p % 3 == 0 ? p : -1);
      seen.push_back(p);
    }
    scene->problem.images.push_back(std::move(image));
    scene->point_of_keypoint.push_back(std::move(seen));
  }

  BundleSceneOptions options_;
  Random random_;
  double yaw_ = 0;
};

inline BundleScene MakeBundleScene(const BundleSceneOptions& options = {}) {
  return BundleSceneMaker(options).Make();
}

}  // namespace deja_view::test
