#include "deja_view/views/view_choice.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"
#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "max_coverage.hpp"

namespace deja_view {
namespace {

/// Pixels of the small render between points of a surface, for some 300 of these.
int Step(const Camera& camera) {
  return std::max(1, static_cast<int>(std::sqrt(camera.width() * camera.height() / 300.0)));
}

/// Distance beyond which nothing looks alike: half of what the query sees would turn by 45 degrees
/// or be twice as near.
double Reach(const SeenSurface& query) {
  std::vector<double> distances;
  for (const Eigen::Vector3d& p_N : query.points_N) {
    distances.push_back((p_N - query.T_N_C.t).norm());
  }
  if (distances.empty()) {
    return 0;
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

/// The same place, looking the other way: half a turn about the vertical.
Rigid3 LookingBack(const Rigid3& T_N_C, const Rigid3& T_C_V) {
  const Eigen::Quaterniond half_turn(0, 0, 0, 1);
  const Eigen::Quaterniond q_N_V = half_turn * T_N_C.q * T_C_V.q;
  return {T_N_C.q.conjugate() * q_N_V, T_C_V.t};
}

}  // namespace

std::vector<std::string> ChoiceOptions::Validate() const {
  Requirements r;
  r.Range("candidates", candidates, 1, 1000);
  r.Range("views_per_image", views_per_image, 0, 1000);
  r.That(min_gain > 0 && std::isfinite(min_gain), "min_gain", min_gain, "more than 0");
  r.That(enough > 0 && enough <= 1, "enough", enough, "more than 0, at most 1");
  r.That(view_worth > 0 && view_worth <= 1, "view_worth", view_worth, "more than 0, at most 1");
  r.Group("look", look.Validate());
  return r.errors();
}

struct ViewChooser::Around {
  SeenSurface photograph;
  std::vector<SeenSurface> seen;  // of candidates
  std::vector<Rigid3> T_C_V;
  int not_free = 0;
  int uncertain = 0;
};

ViewChooser::ViewChooser(const ChoiceOptions& choice,
                         const SamplingOptions& sampling,
                         const GateOptions& gate,
                         std::shared_ptr<const Camera> camera,
                         std::vector<Eigen::Vector3d> flown_N)
    : choice_(choice),
      sampling_(sampling),
      gate_options_(gate),
      gate_(gate, std::move(camera), std::move(flown_N)) {
  DEJA_VIEW_CHECK(choice.Validate().empty());
  sampling_.views = choice.candidates;
  sampling_.candidates = std::max(sampling.candidates, 4 * choice.candidates);
}

ViewChooser::Around ViewChooser::LookAround(const PlacedImage& image,
                                            const ViewRenderer& renderer) const {
  Around around;
  const auto see = [&](const RenderedView& view, const Rigid3& T_N_V) {
    return SeeSurface(view, gate_.small_camera(), T_N_V, gate_options_, Step(gate_.small_camera()));
  };
  const Camera& small = gate_.small_camera();
  around.photograph = see(renderer.Render(small, image.T_N_C, {1, 0, 1}), image.T_N_C);
  const auto accept = [&](const Rigid3& T_C_V) {
    RenderedView view;
    const GateVerdict verdict = gate_.Judge(renderer, image.T_N_C, T_C_V, &view);
    around.not_free += verdict == GateVerdict::kNotFree ? 1 : 0;
    around.uncertain += verdict == GateVerdict::kUncertain ? 1 : 0;
    if (verdict == GateVerdict::kAccepted) {
      around.seen.push_back(see(view, image.T_N_C * T_C_V));
      around.T_C_V.push_back(T_C_V);
    }
    return verdict == GateVerdict::kAccepted;
  };
  const std::vector<Rigid3> sampled = SampleViews(sampling_, image.stamp_ns, accept);
  if (choice_.reversed) {
    for (const Rigid3& T_C_V : sampled) {
      accept(LookingBack(image.T_N_C, T_C_V));
    }
  }
  return around;
}

std::vector<ChosenViews> ViewChooser::Choose(
    const std::vector<PlacedImage>& images,
    const ViewRenderer& renderer,
    int threads,
    const std::function<void(std::size_t done, std::size_t total)>& on_progress) const {
  std::vector<Around> around(images.size());
  std::mutex mutex;
  std::size_t done = 0;  // rounds about an image: looking about it is one, comparing another
  const std::size_t rounds = 2 * images.size();
  ParallelFor(threads, images.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      around[i] = LookAround(images[i], renderer);
      const std::lock_guard<std::mutex> lock(mutex);
      on_progress(++done, rounds);
    }
  });

  struct Candidate {
    std::size_t image;
    std::size_t number;  // among the image's
  };
  std::vector<Candidate> candidates;
  std::vector<const SeenSurface*> seen;
  for (std::size_t i = 0; i < around.size(); ++i) {
    for (std::size_t k = 0; k < around[i].seen.size(); ++k) {
      candidates.push_back({i, k});
      seen.push_back(&around[i].seen[k]);
    }
  }
  MaxCoverage coverage(seen.size());
  std::size_t compared = 0;
  ParallelFor(threads, seen.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t q = begin; q < end; ++q) {
      const auto look = [&, reach = Reach(*seen[q])](const SeenSurface& known) {
        const bool is_near = (known.T_N_C.t - seen[q]->T_N_C.t).norm() <= reach;
        return is_near ? SameLook(*seen[q], known, gate_.small_camera(), choice_.look) : 0.0;
      };
      for (const Around& other : around) {
        coverage.Raise(q, std::min(1.0, look(other.photograph) / choice_.enough));
      }
      for (std::size_t v = 0; v < seen.size(); ++v) {
        coverage.Add(q, v, std::min(1.0, choice_.view_worth * look(*seen[v]) / choice_.enough));
      }
      const std::lock_guard<std::mutex> lock(mutex);
      on_progress(images.size() * (seen.size() + ++compared) / seen.size(), rounds);
    }
  });
  const auto budget = static_cast<std::size_t>(
      std::lround(choice_.views_per_image * static_cast<double>(images.size())));
  std::vector<ChosenViews> chosen(images.size());
  for (std::size_t i = 0; i < around.size(); ++i) {
    chosen[i].not_free = around[i].not_free;
    chosen[i].uncertain = around[i].uncertain;
  }
  for (const std::size_t v : coverage.Choose(budget, choice_.min_gain)) {
    const Candidate& candidate = candidates[v];
    chosen[candidate.image].T_C_V.push_back(around[candidate.image].T_C_V[candidate.number]);
  }
  return chosen;
}

}  // namespace deja_view
