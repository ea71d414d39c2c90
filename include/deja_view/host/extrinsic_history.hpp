#pragma once

#include "deja_view/geometry/rigid3.hpp"

#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <utility>

namespace deja_view {

/// The calibrations T_B_C that an odometry sends, as far as they are believed.
///
/// An odometry that refines its calibration online moves it by little between two messages: up to
/// kStepM and kStepRad. What jumps further is not believed, unless kConfirmations messages in a row
/// agree with it, as after a restart. The first one is believed.
class ExtrinsicHistory {
 public:
  static constexpr double kStepM = 0.05;
  static constexpr double kStepRad = 0.05;
  static constexpr int kConfirmations = 20;

  /// `key` orders the calibrations in time [ns]. Whether this one is believed.
  bool Add(std::int64_t key, const Rigid3& T_B_C);

  /// The newest one that is believed, up to this time; nothing when all are later.
  std::optional<Rigid3> At(std::int64_t key) const;

  /// Whether the last one, believed or not, is of this time or later.
  bool Reaches(std::int64_t key) const { return last_key_ >= key; }

 private:
  bool Believes(const Rigid3& T_B_C);

  std::int64_t last_key_ = std::numeric_limits<std::int64_t>::min();
  std::deque<std::pair<std::int64_t, Rigid3>> believed_;  ///< in order of arrival
  std::optional<Rigid3> jumped_;                          ///< the last one, if it is not believed
  int agreeing_ = 0;                                      ///< jumps in a row that agree
};

}  // namespace deja_view
