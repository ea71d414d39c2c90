#include "deja_view/base/check.hpp"

#include <algorithm>
#include <utility>

#include "loop_closer_impl.hpp"

// Virtual views: from their arrival to the index of places.
namespace deja_view {
namespace {

constexpr std::int64_t kSameStampNs = 500;  // VIOs round stamps to doubles of seconds: 120 ns

int TagOf(const StoredView& view) {
  return view.index + 1;  // 0 is the real image
}

}  // namespace

std::string LoopCloserOptions::SufficientViewFeatures() const {
  return views.use_offline ? EnumToString(features.kind) : "";
}

std::vector<std::string> VirtualViewOptions::Validate() const {
  std::vector<std::string> errors;
  const auto require = [&](bool ok, const char* text) {
    if (!ok) {
      errors.emplace_back(text);
    }
  };
  require(keep >= 0, "keep must not be negative");
  require(max_features >= 1, "max_features must be at least 1");
  require(max_tried >= 0, "max_tried must not be negative");
  require(max_waiting >= 0, "max_waiting must not be negative");
  require(min_certainty >= 0 && min_certainty <= 1, "min_certainty must be in [0, 1]");
  require(min_features >= 1, "min_features must be at least 1");
  require(min_agreement >= 0 && min_agreement <= 1, "min_agreement must be in [0, 1]");
  require(min_judged >= 1, "min_judged must be at least 1");
  require(max_depth_sigma > 0, "max_depth_sigma must be positive");
  require(unknown_depth_sigma > 0, "unknown_depth_sigma must be positive");
  return errors;
}

std::optional<std::size_t> LoopCloser::Impl::KeyframeAt(std::int64_t stamp_ns) const {
  std::optional<std::size_t> found;
  std::int64_t nearest = kSameStampNs + 1;
  for (auto it = stamps_.lower_bound(stamp_ns - kSameStampNs);
       it != stamps_.end() && it->first <= stamp_ns + kSameStampNs;
       ++it) {
    const std::int64_t distance = std::abs(it->first - stamp_ns);
    if (distance < nearest) {
      nearest = distance;
      found = it->second;
    }
  }
  return found;
}

ViewOutcome LoopCloser::Impl::AddVirtualView(const VirtualView& view) {
  ++view_counts.received;
  if (options.views.keep == 0) {
    return Count(ViewOutcome::kSurpassed);
  }
  const std::optional<std::size_t> keyframe = KeyframeAt(view.stamp_ns);
  try {
    CheckView(view, extractor->DescriptorName());
    if (keyframe && !keyframes[*keyframe].is_place) {
      return Count(ViewOutcome::kNoPlace);  // before work is spent on it
    }
    StoredView stored = MakeStoredView(view, *view_extractor_, options.views);
    stored.camera = cameras_.Share(stored.camera);
    if (keyframe) {
      return Count(AttachView(*keyframe, std::move(stored)));
    }
    waiting_views_.push_back({view.stamp_ns, std::move(stored)});
  } catch (const InputError&) {
    ++view_counts.refused;
    throw;
  }
  if (waiting_views_.size() > static_cast<std::size_t>(options.views.max_waiting)) {
    waiting_views_.pop_front();
    ++view_counts.no_keyframe;
  }
  view_counts.waiting = static_cast<std::int64_t>(waiting_views_.size());
  return ViewOutcome::kWaiting;
}

ViewOutcome LoopCloser::Impl::Count(ViewOutcome outcome) {
  switch (outcome) {
    case ViewOutcome::kKept:
      ++view_counts.kept;
      break;
    case ViewOutcome::kWaiting:
      break;
    case ViewOutcome::kDuplicate:
      ++view_counts.duplicates;
      break;
    case ViewOutcome::kNoPlace:
      ++view_counts.no_place;
      break;
    case ViewOutcome::kUncertain:
      ++view_counts.uncertain;
      break;
    case ViewOutcome::kDisagrees:
      ++view_counts.disagree;
      break;
    case ViewOutcome::kSurpassed:
      ++view_counts.surpassed;
      break;
  }
  return outcome;
}

void LoopCloser::Impl::AttachWaitingViews(std::size_t keyframe) {
  const std::int64_t stamp_ns = keyframes[keyframe].stamp_ns;
  for (auto it = waiting_views_.begin(); it != waiting_views_.end();) {
    if (std::abs(it->stamp_ns - stamp_ns) > kSameStampNs) {
      ++it;
      continue;
    }
    Count(AttachView(keyframe, std::move(it->view)));
    it = waiting_views_.erase(it);
  }
  view_counts.waiting = static_cast<std::int64_t>(waiting_views_.size());
}

ViewOutcome LoopCloser::Impl::AttachView(std::size_t keyframe, StoredView view) {
  StoredKeyframe& k = keyframes[keyframe];
  if (!k.is_place) {
    return ViewOutcome::kNoPlace;
  }
  const auto has_index = [&](const StoredView& other) { return other.index == view.index; };
  if (std::any_of(k.views.begin(), k.views.end(), has_index)) {
    return ViewOutcome::kDuplicate;
  }
  if (static_cast<int>(view.keypoints.size()) < options.views.min_features) {
    return ViewOutcome::kUncertain;
  }
  if (!AgreesWithSource(k, view)) {
    return ViewOutcome::kDisagrees;
  }
  if (k.views.size() >= static_cast<std::size_t>(options.views.keep)) {
    const std::optional<std::size_t> worst = FindSurpassed(&k, &view);
    if (!worst) {
      return ViewOutcome::kSurpassed;
    }
    const auto it = k.views.begin() + static_cast<std::ptrdiff_t>(*worst);
    places.Remove(static_cast<int>(keyframe), TagOf(*it));
    if (scored_places_) {
      scored_places_->Remove(static_cast<int>(keyframe), TagOf(*it));
    }
    view_bytes_ -= it->MemoryBytes() + sizeof(StoredView);
    k.views.erase(it);
    --view_counts.kept;
    ++view_counts.surpassed;
  }
  IndexView(keyframe, std::move(view));
  return ViewOutcome::kKept;
}

void LoopCloser::Impl::IndexView(std::size_t keyframe, StoredView view) {
  AddPlace(static_cast<int>(keyframe), vocabulary->Bag(view.descriptors), TagOf(view));
  view_bytes_ += view.MemoryBytes() + sizeof(StoredView);
  std::vector<StoredView>& views = keyframes[keyframe].views;
  views.push_back(std::move(view));
}

bool LoopCloser::Impl::AgreesWithSource(const StoredKeyframe& keyframe,
                                        const StoredView& view) const {
  const RigCamera rig = ToRigCamera(view, keyframe.features.T_B_C, options.views);
  const Agreement agreement = verifier.Agree(rig, keyframe.features);
  return agreement.visible < options.views.min_judged ||
         agreement.found >= options.views.min_agreement * agreement.visible;
}

double LoopCloser::Impl::SimilarityToSource(const StoredKeyframe& keyframe,
                                            const StoredView& view) const {
  return places.Score(vocabulary->Bag(view.descriptors),
                      vocabulary->Bag(keyframe.features.descriptors));
}

// The view that has to make room, unless it is the new one.
std::optional<std::size_t> LoopCloser::Impl::FindSurpassed(StoredKeyframe* keyframe,
                                                           StoredView* view) const {
  view->similarity = SimilarityToSource(*keyframe, *view);
  std::optional<std::size_t> worst;
  double least = view->similarity;
  for (std::size_t i = 0; i < keyframe->views.size(); ++i) {
    StoredView& other = keyframe->views[i];
    if (other.similarity < 0) {
      other.similarity = SimilarityToSource(*keyframe, other);
    }
    if (other.similarity < least) {
      least = other.similarity;
      worst = i;
    }
  }
  return worst;
}

std::vector<RigCamera> LoopCloser::Impl::RigOf(std::size_t keyframe) const {
  std::vector<RigCamera> rig;
  for (const StoredView& view : keyframes[keyframe].views) {
    rig.push_back(ToRigCamera(view, keyframes[keyframe].features.T_B_C, options.views));
  }
  return rig;
}

void LoopCloser::Impl::AddPlace(int keyframe, const BowVector& bow, int tag) {
  places.Add(keyframe, bow, tag);
  if (scored_places_) {
    scored_places_->Add(keyframe, bow, tag);
  }
  (tag == 0 ? place_words_ : view_words_) += bow.entries.size();
}

std::size_t LoopCloser::Impl::ViewMemoryBytes() const {
  const double words = static_cast<double>(place_words_ + view_words_);
  const std::size_t index = places.memory_bytes() - empty_index_bytes_;
  const double share = words > 0 ? static_cast<double>(view_words_) / words : 0.0;
  return view_bytes_ + static_cast<std::size_t>(share * static_cast<double>(index));
}

}  // namespace deja_view
