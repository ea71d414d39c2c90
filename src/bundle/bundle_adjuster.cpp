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
  Adjustment(const BundleOptions& options, BundleProblem* problem)
      : options_(options), problem_(*problem) {}

  /// Empty, or why the round could not be done.
  std::string RunRound(int index, BundleRound* round) {
    const auto start = Clock::now();
    round->error_px = ErrorPx(index);
    FindPoints(index, round);
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
    const std::string gap = internal::FindGap(problem_, points);
    if (!gap.empty()) {
      return gap;
    }
    const std::vector<double> errors = ErrorsOf(problem_, points);
    round->rms_before_px = Rms(errors);
    round->observations = static_cast<int>(errors.size());
    round->adjusted_points = static_cast<int>(points.size());
    round->matching_s = SecondsSince(start);
    return Solve(points, round);
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
  double ErrorPx(int index) const {
    const double share =
        options_.rounds > 1 ? static_cast<double>(index) / (options_.rounds - 1) : 1;
    return options_.first_error_px *
           std::pow(options_.last_error_px / options_.first_error_px, share);
  }

  void FindPoints(int index, BundleRound* round) {
    if (index == 0) {
      pairs_ = internal::ChooseImagePairs(options_, problem_);
      matches_ = internal::MatchDescriptors(options_, problem_, pairs_);
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

  std::string Solve(const std::vector<int>& points, BundleRound* round) {
    const auto start = Clock::now();
    internal::BundleSolver solver(options_, problem_, points);
    const auto report = solver.Solve();
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
  BundleProblem& problem_;
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
                           const std::function<void(const BundleRound&)>& on_round) {
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
  Adjustment adjustment(options, problem);
  for (int i = 0; i < options.rounds; ++i) {
    summary.rounds.emplace_back();
    summary.obstacle = adjustment.RunRound(i, &summary.rounds.back());
    if (!summary.is_usable()) {
      problem->cameras = cameras;
      problem->points.clear();
      for (std::size_t k = 0; k < before.size(); ++k) {
        problem->images[k].T_W_B = before[k];
      }
      return summary;
    }
    if (on_round) {
      on_round(summary.rounds.back());
    }
  }
  adjustment.Finish();
  Summarise(options, *problem, before, &summary);
  return summary;
}

}  // namespace deja_view
