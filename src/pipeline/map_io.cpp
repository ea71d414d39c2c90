#include "deja_view/base/check.hpp"

#include "loop_closer_impl.hpp"
namespace deja_view {
void LoopCloser::Impl::Save(const std::filesystem::path&) const {
  ThrowInputError("not yet");
}
void LoopCloser::Impl::Load(const std::filesystem::path&) {
  ThrowInputError("not yet");
}
}  // namespace deja_view
