#include "explain/explanation.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

bool IsNumber(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isdigit(c) != 0;
  });
}

std::string Seconds(std::int64_t stamp_ns) {
  return fmt::format("{}.{:09d} s", stamp_ns / 1'000'000'000, stamp_ns % 1'000'000'000);
}

/// What one can do about a refusal.
std::string Advice(RejectReason reason) {
  switch (reason) {
    case RejectReason::kNone:
      return "accepted";
    case RejectReason::kNoCandidate:
      return "no keyframe looked alike or was near: the place was never tried";
    case RejectReason::kTooFewPoints:
    case RejectReason::kTooFewMatches:
      return "too few points look alike: too little texture, blur, another exposure, or an angle "
             "from which it looks different; virtual views help against the last";
    case RejectReason::kTooFewInliers:
      return "no pose explains more of the matches than chance: another place, or seen from too "
             "far beside; virtual views of the place help";
    case RejectReason::kByChance:
      return "so few agree that a wrong pose might as well: more points would tell (motion_stereo, "
             "a slower flight, more light)";
    case RejectReason::kLowInlierRatio:
      return "most of what should be visible is not where it should be: a copy of a part of the "
             "scene, something that moved, or poor points";
    case RejectReason::kTooFar:
      return "the pose puts the cameras too far apart for the scene";
    case RejectReason::kTooMuchYaw:
      return "the pose turns the cameras too far apart";
    case RejectReason::kGravity:
      return "the images disagree with the odometry about where down is: check the extrinsics and "
             "the calibration (deja_view check, deja_view bundle --refine)";
    case RejectReason::kUncertain:
      return "the pose is too uncertain: inliers that are few, crowded or far";
    case RejectReason::kInconsistent:
      return "right by itself, but not yet supported by other loops (consistency.min_support) or "
             "contradicted by them";
    case RejectReason::kImplausible:
      return "the odometry would need far more drift than it can have (consistency)";
    case RejectReason::kWithdrawn:
      return "accepted at first, and contradicted by later loops";
  }
  return "";
}

std::string Prediction(const PairExplanation& pair) {
  if (!pair.T_Bold_Bcurrent_predicted) {
    return "prediction: none, the two are not of one world yet";
  }
  const Rigid3& T = *pair.T_Bold_Bcurrent_predicted;
  return fmt::format(
      "prediction: {:.2f} m and {:.1f} degrees apart; {:.0f} % of the current keyframe's {} points "
      "are then in the old image",
      T.t.norm(),
      RotationAngle(T.q) / kDegree,
      100 * pair.predicted_overlap,
      pair.points_current);
}

std::string Retrieval(const PairExplanation& pair) {
  if (!pair.is_place) {
    return "candidates: the old keyframe is no place of the map (map_spacing_m, map_cover): "
           "another one stands for what it sees";
  }
  if (pair.rank < 0) {
    return fmt::format(
        "candidates: not among the {} that were tried (too young: candidates.min_age_s; or it "
        "looked less alike than others: candidates.retrieved, max_verified)",
        pair.candidates);
  }
  return fmt::format("candidates: number {} of {} that were tried, score {:.4f}",
                     pair.rank + 1,
                     pair.candidates,
                     pair.score);
}

void AddAttempt(const std::string& what,
                const PairExplanation::Attempt& attempt,
                std::vector<std::string>* lines) {
  const Verification& v = attempt.verification;
  if (attempt.readings.empty()) {
    lines->push_back(fmt::format("{}: {} matches, at most {} agree on a pose: {}",
                                 what,
                                 v.matches,
                                 v.ransac_inliers,
                                 EnumToString(v.reason)));
    return;
  }
  lines->push_back(
      fmt::format("{}: {} inliers, {} of {} visible points found, {:.2f} m and {:.1f} degrees "
                  "apart, reprojection {:.1f} px",
                  what,
                  v.inliers,
                  v.found,
                  v.visible,
                  v.T_Bold_Bcurrent.t.norm(),
                  RotationAngle(v.T_Bold_Bcurrent.q) / kDegree,
                  v.rmse_px));
  for (const GateReading& reading : attempt.readings) {
    lines->push_back(fmt::format("  {} verification.{}: {:.3g}, {} {:.3g}",
                                 reading.passes() ? "passes" : "FAILS ",
                                 reading.option,
                                 reading.value,
                                 reading.is_at_least ? "at least" : "at most",
                                 reading.limit));
  }
}

Json ToJson(const PairExplanation::Attempt& attempt) {
  const Verification& v = attempt.verification;
  Json json = {{"reason", EnumToString(v.reason)},
               {"matches", v.matches},
               {"ransac_inliers", v.ransac_inliers},
               {"inliers", v.inliers},
               {"visible", v.visible},
               {"found", v.found}};
  json["gates"] = Json::array();
  for (const GateReading& reading : attempt.readings) {
    json["gates"].push_back({{"option", "verification." + reading.option},
                             {"value", reading.value},
                             {"limit", reading.limit},
                             {"passes", reading.passes()}});
  }
  return json;
}

}  // namespace

std::int64_t ParseStamp(const std::string& option, const std::string& text) {
  constexpr std::size_t kLeastOfNanoseconds = 11;  // digits
  constexpr std::size_t kMostOfNanoseconds = 19;
  constexpr std::size_t kMostOfSeconds = 10;
  constexpr std::size_t kDecimals = 9;
  const std::size_t point = text.find('.');
  const std::string whole = text.substr(0, point);
  std::string decimals = point == std::string::npos ? "0" : text.substr(point + 1);
  const bool is_number = IsNumber(whole) && IsNumber(decimals) && decimals.size() <= kDecimals;
  if (is_number && point == std::string::npos && whole.size() >= kLeastOfNanoseconds &&
      whole.size() <= kMostOfNanoseconds) {
    if (whole.size() < kMostOfNanoseconds || whole < "9") {
      return std::stoll(whole);
    }
  }
  if (!is_number || whole.size() > kMostOfSeconds) {
    ThrowInputError("{} {}: expected a stamp in seconds or nanoseconds", option, text);
  }
  decimals.resize(kDecimals, '0');
  return std::stoll(whole) * 1'000'000'000 + std::stoll(decimals);
}

RejectReason FinalReason(const PairExplanation& pair, const std::vector<LoopReport>& loops) {
  RejectReason reason = pair.reason;
  for (const LoopReport& loop : loops) {
    if (loop.current == pair.current && loop.old == pair.old) {
      reason = loop.reason;
    }
  }
  return reason;
}

std::vector<std::string> ExplanationLines(const PairExplanation& pair, RejectReason final_reason) {
  std::vector<std::string> lines;
  lines.push_back(fmt::format("keyframe {} of {} and the old keyframe {} of {}: {}",
                              pair.current,
                              Seconds(pair.stamp_current_ns),
                              pair.old,
                              Seconds(pair.stamp_old_ns),
                              EnumToString(final_reason)));
  lines.push_back(Advice(final_reason));
  lines.push_back(Retrieval(pair));
  lines.push_back(Prediction(pair));
  lines.push_back(
      fmt::format("points: {} of the current keyframe, {} of the old one; {} look "
                  "alike at first",
                  pair.points_current,
                  pair.points_old,
                  pair.first_matches.size()));
  AddAttempt("real images", pair.real, &lines);
  if (pair.with_views) {
    AddAttempt("with the place's virtual views", *pair.with_views, &lines);
  }
  if (pair.reason != final_reason) {
    lines.push_back(fmt::format(
        "at that moment: {}; later: {}", EnumToString(pair.reason), EnumToString(final_reason)));
  }
  return lines;
}

Json ToJson(const PairExplanation& pair, RejectReason final_reason) {
  Json json = {{"current", pair.current},
               {"old", pair.old},
               {"stamp_current_ns", pair.stamp_current_ns},
               {"stamp_old_ns", pair.stamp_old_ns},
               {"reason", EnumToString(final_reason)},
               {"reason_at_first", EnumToString(pair.reason)},
               {"is_place", pair.is_place},
               {"candidates", pair.candidates},
               {"rank", pair.rank},
               {"score", pair.score},
               {"points_current", pair.points_current},
               {"points_old", pair.points_old},
               {"first_matches", pair.first_matches.size()}};
  json["predicted_overlap"] =
      pair.T_Bold_Bcurrent_predicted ? Json(pair.predicted_overlap) : Json();
  json["real"] = ToJson(pair.real);
  json["with_views"] = pair.with_views ? ToJson(*pair.with_views) : Json();
  return json;
}

}  // namespace deja_view
