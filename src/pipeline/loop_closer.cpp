#include "deja_view/pipeline/loop_closer.hpp"

#include "deja_view/base/check.hpp"

#include <utility>

#include "loop_closer_impl.hpp"

namespace deja_view {

LoopCloser::LoopCloser(const LoopCloserOptions& options,
                       std::shared_ptr<const Camera> camera,
                       const Rigid3& T_B_C,
                       std::shared_ptr<const Vocabulary> vocabulary,
                       SolveExecutor executor)
    : impl_(std::make_unique<LoopCloserImpl>(
          options, std::move(camera), T_B_C, std::move(vocabulary), std::move(executor))) {}

LoopCloser::~LoopCloser() = default;
LoopCloser::LoopCloser(LoopCloser&&) noexcept = default;
LoopCloser& LoopCloser::operator=(LoopCloser&&) noexcept = default;

void LoopCloser::SetExtrinsic(const Rigid3& T_B_C) {
  impl_->SetExtrinsic(T_B_C);
}

KeyframeReport LoopCloser::AddKeyframe(const KeyframeInput& input) {
  return impl_->AddKeyframe(input);
}

ViewOutcome LoopCloser::AddVirtualView(const VirtualView& view) {
  return impl_->AddVirtualView(view);
}

void LoopCloser::Ask(std::int64_t stamp_current_ns,
                     std::int64_t stamp_old_ns,
                     std::int64_t within_ns) {
  impl_->Ask(stamp_current_ns, stamp_old_ns, within_ns);
}

bool LoopCloser::UpdateLoop(int current, const Rigid3& T_Bold_Bcurrent) {
  return impl_->UpdateLoop(current, T_Bold_Bcurrent);
}

std::vector<LoopReport> LoopCloser::OptimizeFully() {
  return impl_->OptimizeFully();
}

int LoopCloser::keyframe_count() const {
  return impl_->keyframes().size();
}

KeyframeInfo LoopCloser::keyframe(int index) const {
  DEJA_VIEW_CHECK(index >= 0 && index < keyframe_count());
  const KeyframeMap::Keyframe& stored = impl_->keyframes()[index];
  const PoseGraphNode node = impl_->keyframes().node(index);
  return {index,
          node.sequence,
          stored.stamp_ns,
          node.T_W_B,
          node.T_M_B(),
          stored.is_place,
          static_cast<int>(impl_->shelf().Of(index).size())};
}

int LoopCloser::sequence_count() const {
  return impl_->keyframes().sequence_count();
}

bool LoopCloser::is_joined(int sequence) const {
  return impl_->keyframes().graph().IsAnchored(sequence);
}

int LoopCloser::place_count() const {
  return static_cast<int>(impl_->keyframes().places().size());
}

std::size_t LoopCloser::memory_bytes() const {
  return impl_->memory_bytes();
}

const ViewCounts& LoopCloser::view_counts() const {
  return impl_->shelf().counts();
}

std::size_t LoopCloser::view_memory_bytes() const {
  return impl_->view_memory_bytes();
}

Rigid3 LoopCloser::drift() const {
  return impl_->drift();
}

std::vector<LoopReport> LoopCloser::accepted_loops() const {
  return impl_->loops().Accepted();
}

void LoopCloser::Save(const std::filesystem::path& directory) const {
  impl_->Save(directory);
}

void LoopCloser::Load(const std::filesystem::path& directory) {
  impl_->Load(directory);
}

}  // namespace deja_view
