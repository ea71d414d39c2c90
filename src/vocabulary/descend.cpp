#include "descend.hpp"

namespace deja_view::internal {
namespace portable {
namespace {

int Distance(const Descriptor& a, const Descriptor& b) {
  return HammingDistance(a, b);
}

std::uint32_t NearestChild(const Descriptor& descriptor,
                           const Descriptor* children,
                           std::uint32_t count) {
  std::uint32_t best = 0;
  int best_distance = HammingDistance(descriptor, children[0]);
  for (std::uint32_t i = 1; i < count; ++i) {
    const int distance = HammingDistance(descriptor, children[i]);
    if (distance < best_distance) {
      best_distance = distance;
      best = i;
    }
  }
  return best;
}

#include "descend.inc"

}  // namespace
}  // namespace portable

DescendKernel PortableDescendKernel() {
  return portable::MakeKernel();
}

#ifndef DEJA_VIEW_HAVE_HIGHWAY
DescendKernel ChooseDescendKernel() {
  return PortableDescendKernel();
}
#endif

}  // namespace deja_view::internal
