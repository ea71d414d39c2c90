#include "view_shelf.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/features/make_feature_extractor.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace deja_view {
namespace {

FeatureOptions WithMaxFeatures(FeatureOptions features, int max_features) {
  features.brief.max_features = max_features;
  features.orb.max_features = max_features;
  return features;
}

std::size_t BytesOf(const StoredView& view) {
  return sizeof(StoredView) + view.MemoryBytes();
}

std::size_t BytesOf(const VirtualView& view) {
  constexpr std::size_t kPerFeature = sizeof(Keypoint) + sizeof(Descriptor) + 2 * sizeof(float);
  const auto bytes = [](const cv::Mat& image) { return image.total() * image.elemSize(); };
  return sizeof(VirtualView) + bytes(view.image) + bytes(view.depth_mm) + bytes(view.certainty) +
         kPerFeature * view.features.features.keypoints.size();
}

/// How unlike what the two cameras see is: the angle between their axes, and that by which their
/// distance shifts the scene [rad].
double Difference(const Rigid3& T_C_V, const NearCamera& near) {
  constexpr double kDepth_m = 3;  // where nobody knows
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  const double cosine = (T_C_V.q * axis).dot(near.T_C_near.q * axis);
  const double depth = near.depth > 0 ? near.depth : kDepth_m;
  return std::acos(std::clamp(cosine, -1.0, 1.0)) + (T_C_V.t - near.T_C_near.t).norm() / depth;
}

}  // namespace

ViewShelf::ViewShelf(const VirtualViewOptions& options,
                     const FeatureOptions& features,
                     const LoopVerifier* verifier,
                     PlaceFinder* places)
    : options_(options),
      features_(features),
      extractor_(MakeFeatureExtractor(WithMaxFeatures(features, options.max_features))),
      verifier_(verifier),
      places_(places) {}

ViewOutcome ViewShelf::Add(const VirtualView& view, const KeyframeMap& keyframes) {
  ++counts_.received;
  try {
    return Count(TryToAdd(view, keyframes));
  } catch (const InputError&) {
    ++counts_.refused;
    throw;
  }
}

ViewOutcome ViewShelf::TryToAdd(const VirtualView& view, const KeyframeMap& keyframes) {
  if (options_.keep == 0) {
    return ViewOutcome::kSurpassed;
  }
  CheckView(view, extractor_->DescriptorName());
  const std::optional<int> keyframe = keyframes.At(view.stamp_ns);
  if (keyframe && !keyframes[*keyframe].is_place) {
    return ViewOutcome::kNoPlace;  // before work is spent on it
  }
  if (keyframe) {
    return Attach(*keyframe, view, keyframes);
  }
  LetWait(view);
  return ViewOutcome::kWaiting;
}

// As it came: only its keyframe tells where down is.
void ViewShelf::LetWait(const VirtualView& view) {
  waiting_.push_back(view);
  waiting_bytes_ += BytesOf(view);
  const auto most = static_cast<std::size_t>(options_.max_waiting);
  const auto most_bytes = static_cast<std::size_t>(options_.max_waiting_mb) << 20U;
  while (waiting_.size() > most || waiting_bytes_ > most_bytes) {
    waiting_bytes_ -= BytesOf(waiting_.front());
    waiting_.pop_front();
    ++counts_.no_keyframe;
  }
}

StoredView ViewShelf::Describe(const VirtualView& view, const Rigid3& T_W_C) const {
  const VerticalField vertical = MakeVerticalField(features_, *view.camera, (T_W_C * view.T_C_V).q);
  return MakeStoredView(view, *extractor_, vertical, options_);
}

ViewOutcome ViewShelf::Count(ViewOutcome outcome) {
  counts_.waiting = static_cast<std::int64_t>(waiting_.size());
  switch (outcome) {
    case ViewOutcome::kKept:
      ++counts_.kept;
      break;
    case ViewOutcome::kWaiting:
      break;
    case ViewOutcome::kDuplicate:
      ++counts_.duplicates;
      break;
    case ViewOutcome::kNoPlace:
      ++counts_.no_place;
      break;
    case ViewOutcome::kUncertain:
      ++counts_.uncertain;
      break;
    case ViewOutcome::kDisagrees:
      ++counts_.disagree;
      break;
    case ViewOutcome::kSurpassed:
      ++counts_.surpassed;
      break;
  }
  return outcome;
}

void ViewShelf::AttachWaiting(int keyframe, const KeyframeMap& keyframes) {
  const std::int64_t stamp_ns = keyframes[keyframe].stamp_ns;
  for (auto it = waiting_.begin(); it != waiting_.end();) {
    if (!KeyframeMap::IsSameStamp(it->stamp_ns, stamp_ns)) {
      ++it;
      continue;
    }
    const VirtualView view = std::move(*it);
    waiting_bytes_ -= BytesOf(view);
    it = waiting_.erase(it);
    Count(Attach(keyframe, view, keyframes));
  }
}

ViewOutcome ViewShelf::Attach(int keyframe, const VirtualView& sent, const KeyframeMap& keyframes) {
  if (!keyframes[keyframe].is_place) {
    return ViewOutcome::kNoPlace;
  }
  std::vector<StoredView>& views = kept_[keyframe];
  const auto has_index = [&](const StoredView& other) { return other.index == sent.index; };
  if (std::any_of(views.begin(), views.end(), has_index)) {
    return ViewOutcome::kDuplicate;
  }
  StoredView view = Describe(sent, keyframes.node(keyframe).T_W_B * keyframes.T_B_C(keyframe));
  view.camera = cameras_.Share(view.camera);
  if (static_cast<int>(view.keypoints.size()) < options_.min_features) {
    return ViewOutcome::kUncertain;
  }
  const KeyframeFeatures& source = keyframes.features(keyframe);
  if (!AgreesWithSource(source, view)) {
    return ViewOutcome::kDisagrees;
  }
  if (views.size() >= static_cast<std::size_t>(options_.keep)) {
    const std::optional<std::size_t> worst = FindSurpassed(source, &views, &view);
    if (!worst) {
      return ViewOutcome::kSurpassed;
    }
    Drop(keyframe, *worst);
  }
  Keep(keyframe, std::move(view));
  return ViewOutcome::kKept;
}

void ViewShelf::Keep(int keyframe, StoredView view) {
  places_->AddView(keyframe, view.index, places_->Bag(view.descriptors));
  bytes_ += BytesOf(view);
  kept_[keyframe].push_back(std::move(view));
}

// Of a view that another one surpasses.
void ViewShelf::Drop(int keyframe, std::size_t i) {
  std::vector<StoredView>& views = kept_[keyframe];
  places_->RemoveView(keyframe, views[i].index);
  bytes_ -= BytesOf(views[i]);
  views.erase(views.begin() + static_cast<std::ptrdiff_t>(i));
  --counts_.kept;
  ++counts_.surpassed;
}

bool ViewShelf::AgreesWithSource(const KeyframeFeatures& source, const StoredView& view) const {
  const Agreement agreement = verifier_->Agree(ToRigCamera(view, source.T_B_C, options_), source);
  return agreement.visible < options_.min_judged ||
         agreement.found >= options_.min_agreement * agreement.visible;
}

double ViewShelf::SimilarityToSource(const KeyframeFeatures& source, const StoredView& view) const {
  return places_->Score(places_->Bag(view.descriptors), places_->Bag(source.descriptors));
}

// The view that has to make room, unless it is the new one.
std::optional<std::size_t> ViewShelf::FindSurpassed(const KeyframeFeatures& source,
                                                    std::vector<StoredView>* views,
                                                    StoredView* view) const {
  view->similarity = SimilarityToSource(source, *view);
  std::optional<std::size_t> worst;
  double least = view->similarity;
  for (std::size_t i = 0; i < views->size(); ++i) {
    StoredView& other = (*views)[i];
    if (other.similarity < 0) {
      other.similarity = SimilarityToSource(source, other);
    }
    if (other.similarity < least) {
      least = other.similarity;
      worst = i;
    }
  }
  return worst;
}

void ViewShelf::Clear() {
  kept_.clear();
  cameras_ = CameraTable();
  bytes_ = 0;
  counts_ = ViewCounts{};
  counts_.waiting = static_cast<std::int64_t>(waiting_.size());
}

void ViewShelf::Restore(int keyframe, std::vector<StoredView> views) {
  views.resize(std::min(views.size(), static_cast<std::size_t>(options_.keep)));
  for (StoredView& view : views) {
    view.camera = cameras_.Share(view.camera);
    Keep(keyframe, std::move(view));
    ++counts_.kept;
  }
}

const std::vector<StoredView>& ViewShelf::Of(int keyframe) const {
  static const std::vector<StoredView> kNone;
  const auto it = kept_.find(keyframe);
  return it == kept_.end() ? kNone : it->second;
}

// The best first: the nearest, or else those that look most alike.
std::vector<std::size_t> ViewShelf::Order(const std::vector<StoredView>& views,
                                          const std::optional<NearCamera>& near,
                                          const BowVector& bow) const {
  std::vector<double> costs;
  for (const StoredView& view : views) {
    costs.push_back(near ? Difference(view.T_C_V, *near)
                         : -places_->Score(bow, places_->Bag(view.descriptors)));
  }
  std::vector<std::size_t> order(views.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return costs[a] < costs[b];
  });
  return order;
}

std::vector<std::vector<RigCamera>> ViewShelf::RigsOf(int keyframe,
                                                      const Rigid3& T_B_C,
                                                      const std::optional<NearCamera>& near,
                                                      const BowVector& bow) const {
  const std::vector<StoredView>& views = Of(keyframe);
  const auto in_rig = static_cast<std::size_t>(options_.in_rig);
  std::vector<std::vector<RigCamera>> rigs;
  for (const std::size_t i : Order(views, near, bow)) {
    if (rigs.empty() || rigs.back().size() == in_rig) {
      if (static_cast<int>(rigs.size()) == options_.rigs) {
        break;
      }
      rigs.emplace_back();
    }
    rigs.back().push_back(ToRigCamera(views[i], T_B_C, options_));
  }
  return rigs;
}

}  // namespace deja_view
