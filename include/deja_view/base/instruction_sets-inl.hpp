// Included by a file of kernels once HWY_TARGET_INCLUDE names that file: with Highway the file is
// compiled once per instruction set, the best of which is picked at run time; without it once,
// plainly. No guard, since Highway includes the file again for each.
#ifdef DEJA_VIEW_HAVE_HIGHWAY
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on
#else
#define HWY_NAMESPACE plain
#define HWY_ONCE 1
#define HWY_BEFORE_NAMESPACE() static_assert(true)
#define HWY_AFTER_NAMESPACE() static_assert(true)
#define HWY_EXPORT(function) static_assert(true)
#define HWY_DYNAMIC_DISPATCH(function) plain::function
#endif
