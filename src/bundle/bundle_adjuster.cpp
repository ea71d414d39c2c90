#include "deja_view/bundle/bundle_adjuster.hpp"

#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <utility>

#include "bundle_check.hpp"
#include "bundle_solver.hpp"
#include "image_matching.hpp"
#include "image_pairs.hpp"
#include "point_selection.hpp"
#include "track_builder.hpp"
#include "triangulation.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

using internal::KeypointMatch;
using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Images that see at least `min_points` of the points.
int CountStrongImages(const BundleProblem& problem,
                      const std::vector<int>& points,
                      int min_points) {
  std::vector<int> seen(problem.images.size(), 0);
  for (const int point : points) {
    for (const BundleObservation& o :
         problem.points[static_cast<std::size_t>(point)].observations) {
      ++seen[static_cast<std::size_t>(o.image)];
    }
  }
  return static_cast<int>(
      std::count_if(seen.begin(), seen.end(), [&](int count) { return count >= min_points; }));
}

std::vector<int> AllPoints(const BundleProblem& problem) {
  std::vector<int> points(problem.points.size());
  std::iota(points.begin(), points.end(), 0);
  return points;
}

/// Errors [px] of all observations of some points; those not seen are left out.
std::vector<double> ErrorsOf(const BundleProblem& problem, const std::vector<int>& points) {
  std::vector<double> errors;
  for (const int point : points) {
    for (const double error :
         internal::ReprojectionErrors(problem, problem.points[static_cast<std::size_t>(point)])) {
      if (std::isfinite(error)) {
        errors.push_back(error);
      }
    }
  }
  return errors;
}

double Rms(const std::vector<double>& errors) {
  double sum = 0;
  for (const double error : errors) {
    sum += error * error;
  }
  return std::sqrt(sum / std::max<double>(1, static_cast<double>(errors.size())));
}

/// The rounds over one problem.
class Adjustment {
 public:
  Adjustment(const BundleOptions& options,
             const std::function<bool(double share)>& on_progress,
             BundleProblem* problem)
      : options_(options), on_progress_(on_progress), problem_(*problem) {}

  bool was_stopped() const { return was_stopped_; }

  /// Empty, or why the round could not be done. A round that is stopped changes no pose.
  std::string RunRound(int index, BundleRound* round) {
    const auto start = Clock::now();
    round->error_px = ErrorPx(index);
    FindPoints(index, round);
    if (!GoesOn(WorkWhenMatched(index))) {
      return "";
    }
    const std::vector<int> points = internal::SelectPoints(problem_, options_.points_per_image);
    const int strong = CountStrongImages(problem_, points, options_.min_points);
    if (strong < 2) {
      return fmt::format(
          "{} of {} images see {} points or more under {} degrees of parallax: too little "
          "movement, too few corners, or poses too wrong to match by",
          strong,
          problem_.images.size(),
          options_.min_points,
          options_.min_parallax_deg);
    }
    std::string gap = internal::FindGap(problem_, points);
    if (!gap.empty()) {
      return gap;
    }
    const std::vector<double> errors = ErrorsOf(problem_, points);
    round->rms_before_px = Rms(errors);
    round->observations = static_cast<int>(errors.size());
    round->adjusted_points = static_cast<int>(points.size());
    round->matching_s = SecondsSince(start);
    return Solve(index, points, round);
  }

  /// Triangulates all tracks once more with the final poses.
  void Finish() {
    const auto rays = internal::UnprojectKeypoints(problem_, options_.threads);
    problem_.points =
        internal::Triangulate(options_, problem_, rays, tracks_, options_.last_error_px);
    for (BundlePoint& point : problem_.points) {
      point.rms_px = Rms(internal::ReprojectionErrors(problem_, point));
    }
  }

 private:
  /// Of all rounds, in units of a round's solver, when a round's corners are matched: matching
  /// takes as long as solving, in the first round twice as long.
  static double WorkWhenMatched(int index) { return 2 * index + 2; }

  /// Whether to go on when so much work is done.
  bool GoesOn(double work) {
    const double all = 2 * options_.rounds + 1;
    was_stopped_ = was_stopped_ || (on_progress_ && !on_progress_(work / all));
    return !was_stopped_;
  }

  double ErrorPx(int index) const {
    const double share =
        options_.rounds > 1 ? static_cast<double>(index) / (options_.rounds - 1) : 1;
    return options_.first_error_px *
           std::pow(options_.last_error_px / options_.first_error_px, share);
  }

  void FindPoints(int index, BundleRound* round) {
    if (index == 0) {
      pairs_ = internal::ChooseImagePairs(options_, problem_);
      matches_ = internal::MatchDescriptors(options_, problem_, pairs_, [&](double share) {
        return GoesOn(share * WorkWhenMatched(index));
      });
    } else {
      const auto more = internal::SearchByProjection(options_, problem_, pairs_, round->error_px);
      matches_.insert(matches_.end(), more.begin(), more.end());
    }
    const auto rays = internal::UnprojectKeypoints(problem_, options_.threads);
    const std::vector<KeypointMatch> kept =
        internal::KeepEpipolar(options_, problem_, rays, matches_, round->error_px, index == 0);
    tracks_ = internal::BuildTracks(problem_, kept);
    problem_.points = internal::Triangulate(options_, problem_, rays, tracks_, round->error_px);
    round->pairs = static_cast<int>(pairs_.size());
    round->matches = static_cast<int>(kept.size());
    round->tracks = static_cast<int>(tracks_.size());
    round->points = static_cast<int>(problem_.points.size());
  }

  std::string Solve(int index, const std::vector<int>& points, BundleRound* round) {
    const auto start = Clock::now();
    internal::BundleSolver solver(options_, problem_, points);
    const auto report =
        solver.Solve([&](double share) { return GoesOn(WorkWhenMatched(index) + share); });
    if (report.was_stopped) {
      return "";
    }
    if (!report.is_usable) {
      return "the solver found no solution";
    }
    solver.Store(&problem_);
    round->iterations = report.iterations;
    round->rms_after_px = Rms(ErrorsOf(problem_, points));
    round->solving_s = SecondsSince(start);
    return "";
  }

  const BundleOptions& options_;
  const std::function<bool(double share)>& on_progress_;
  BundleProblem& problem_;
  bool was_stopped_ = false;
  std::vector<std::pair<int, int>> pairs_;
  std::vector<KeypointMatch> matches_;  ///< of all rounds, right or wrong
  std::vector<internal::Track> tracks_;
};

void Summarise(const BundleOptions& options,
               const BundleProblem& problem,
               const std::vector<Rigid3>& before,
               BundleSummary* summary) {
  const std::vector<int> points = AllPoints(problem);
  summary->points = static_cast<int>(points.size());
  summary->weak_images = summary->images - CountStrongImages(problem, points, options.min_points);
  std::vector<double> errors = ErrorsOf(problem, points);
  summary->observations = static_cast<int>(errors.size());
  summary->rms_px = Rms(errors);
  if (!errors.empty()) {
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    summary->median_px = *middle;
    summary->mean_track = static_cast<double>(errors.size()) / summary->points;
  }
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double shift = (problem.images[i].T_W_B.t - before[i].t).norm();
    summary->mean_shift_m += shift / static_cast<double>(before.size());
    summary->largest_shift_m = std::max(summary->largest_shift_m, shift);
  }
}

}  // namespace

BundleSummary AdjustBundle(const BundleOptions& options,
                           BundleProblem* problem,
                           const std::function<void(const BundleRound&)>& on_round,
                           const std::function<bool(double share)>& on_progress) {
  CheckNone(options.Validate(), "bundle options");
  internal::CheckProblem(*problem);
  BundleSummary summary;
  summary.images = static_cast<int>(problem->images.size());
  if (summary.images < 2) {
    summary.obstacle = "fewer than two images";
    return summary;
  }
  if (problem->relative_priors.empty() && problem->pose_priors.empty()) {
    summary.obstacle = "neither priors of poses nor of relative poses: nothing tells the scale";
    return summary;
  }
  std::vector<Rigid3> before;
  for (const BundleImage& image : problem->images) {
    before.push_back(image.T_W_B);
  }
  const std::vector<BundleCamera> cameras = problem->cameras;
  Adjustment adjustment(options, on_progress, problem);
  for (int i = 0; i < options.rounds && summary.is_usable() && !summary.was_stopped; ++i) {
    BundleRound round;
    summary.obstacle = adjustment.RunRound(i, &round);
    summary.was_stopped = adjustment.was_stopped();
    if (summary.was_stopped && summary.rounds.empty()) {
      summary.obstacle = "stopped before the first round was done";
    }
    if (summary.is_usable() && !summary.was_stopped) {
      summary.rounds.push_back(round);
      if (on_round) {
        on_round(round);
      }
    }
  }
  if (summary.is_usable()) {
    adjustment.Finish();
    Summarise(options, *problem, before, &summary);
  } else {
    problem->cameras = cameras;
    problem->points.clear();
    for (std::size_t k = 0; k < before.size(); ++k) {
      problem->images[k].T_W_B = before[k];
    }
  }
  return summary;
}

}  // namespace deja_view
