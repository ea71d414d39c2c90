#pragma once

#include "deja_view/base/enum_names.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <cstdint>
#include <optional>
#include <stdexcept>

#include <Eigen/Core>

namespace deja_view {

/// What is thought of the z axis of an odometry's world W.
enum class GravityPolicy {
  kGiven,     ///< it is up; a world that clearly lies otherwise is refused
  kEstimate,  ///< it may be any; up is where the cameras' rows are level
};

template <>
inline constexpr auto kEnumNames<GravityPolicy> = EnumNames("given", "estimate");

/// A flight that can't be used at all: the program ends and says why.
class UnusableFlight : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Whether an odometry's world W is level (z up), and the rotation that levels it: a pose graph of
/// four degrees of freedom corrects position and yaw, and leaves roll and pitch as they are.
///
/// Up is told by the images' rows, which a camera that is held upright keeps about level
/// (UpFromLevelRows); of the two directions it is the one away from where the images' lower edge
/// and the optical axis point on average. It is told once, when the cameras have turned enough.
class WorldLevel {
 public:
  explicit WorldLevel(GravityPolicy policy) : policy_(policy) {}

  /// Pose of an image's camera. Throws UnusableFlight for a world that is not level where it ought
  /// to be.
  void Add(const Rigid3& T_W_C);

  /// T_L_W to the level world L: the identity where W is as it ought to be, nothing as long as it
  /// is not told.
  std::optional<Rigid3> T_L_W() const;

 private:
  GravityPolicy policy_;
  std::int64_t images_ = 0;
  Eigen::Matrix3d row_spread_W_ = Eigen::Matrix3d::Zero();  ///< sum over the images
  Eigen::Vector3d down_sum_W_ = Eigen::Vector3d::Zero();
  bool is_told_ = false;
  Rigid3 T_L_W_;
};

}  // namespace deja_view
