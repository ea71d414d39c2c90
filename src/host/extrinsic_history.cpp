#include "deja_view/host/extrinsic_history.hpp"

namespace deja_view {
namespace {

// Remembered to find the one of a keyframe's time.
constexpr std::size_t kMemory = 256;

bool IsStep(const Rigid3& from, const Rigid3& to) {
  return (to.t - from.t).norm() <= ExtrinsicHistory::kStepM &&
         RotationAngle(from.q.conjugate() * to.q) <= ExtrinsicHistory::kStepRad;
}

bool IsSame(const Rigid3& a, const Rigid3& b) {
  return a.t == b.t && a.q.coeffs() == b.q.coeffs();
}

}  // namespace

bool ExtrinsicHistory::Add(std::int64_t key, const Rigid3& T_B_C) {
  last_key_ = key;
  if (!Believes(T_B_C)) {
    return false;
  }
  if (believed_.empty() || !IsSame(believed_.back().second, T_B_C)) {
    believed_.emplace_back(key, T_B_C);
  }
  if (believed_.size() > kMemory) {
    believed_.pop_front();
  }
  return true;
}

bool ExtrinsicHistory::Believes(const Rigid3& T_B_C) {
  bool is_believed = believed_.empty() || IsStep(believed_.back().second, T_B_C);
  if (!is_believed) {
    agreeing_ = jumped_ && IsStep(*jumped_, T_B_C) ? agreeing_ + 1 : 1;
    is_believed = agreeing_ >= kConfirmations;
  }
  jumped_ = is_believed ? std::nullopt : std::optional(T_B_C);
  return is_believed;
}

std::optional<Rigid3> ExtrinsicHistory::At(std::int64_t key) const {
  for (auto extrinsic = believed_.rbegin(); extrinsic != believed_.rend(); ++extrinsic) {
    if (extrinsic->first <= key) {
      return extrinsic->second;
    }
  }
  return std::nullopt;
}

}  // namespace deja_view
