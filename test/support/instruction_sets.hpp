#pragma once

#include <cstdint>

#include <gtest/gtest.h>
#ifdef DEJA_VIEW_HAVE_HIGHWAY
#include <hwy/targets.h>
#endif

namespace deja_view::test {

/// Calls f with each instruction set that this processor has and the kernels were compiled for,
/// then with the one that is picked by default.
template <typename F>
void OnEveryInstructionSet(F f) {
#ifdef DEJA_VIEW_HAVE_HIGHWAY
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    f();
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
#endif
  f();
}

}  // namespace deja_view::test
