#pragma once

#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <fmt/ostream.h>

namespace deja_view {

/// A caller broke a documented precondition: a bug in the program, not in its input.
class CheckError : public std::logic_error {
  using std::logic_error::logic_error;
};

/// Bad input: a file, message or config value. The message names the path, topic or key, the value
/// found and what was expected.
class InputError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

namespace internal {
template <typename A, typename B>
[[noreturn]] void FailCheck(const char* expression, const A& a, const B& b, const char* where) {
  throw CheckError(fmt::format("{}: check failed: {} ({} vs. {})", where, expression, a, b));
}
[[noreturn]] void FailCheck(const char* expression, const char* where);
}  // namespace internal

/// InputError with a fmt-formatted message.
template <typename... Args>
[[noreturn]] void ThrowInputError(fmt::format_string<Args...> format, Args&&... args) {
  throw InputError(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace deja_view

#define DEJA_VIEW_STRINGIZE_(x) #x
#define DEJA_VIEW_STRINGIZE(x) DEJA_VIEW_STRINGIZE_(x)
#define DEJA_VIEW_WHERE __FILE__ ":" DEJA_VIEW_STRINGIZE(__LINE__)

/// Throws CheckError when `condition` does not hold.
#define DEJA_VIEW_CHECK(condition)                                   \
  do {                                                               \
    if (!(condition)) {                                              \
      ::deja_view::internal::FailCheck(#condition, DEJA_VIEW_WHERE); \
    }                                                                \
  } while (false)

/// Throws CheckError with both values when `a op b` does not hold.
#define DEJA_VIEW_CHECK_OP(a, op, b)                                                  \
  do {                                                                                \
    if (!((a)op(b))) {                                                                \
      ::deja_view::internal::FailCheck(#a " " #op " " #b, (a), (b), DEJA_VIEW_WHERE); \
    }                                                                                 \
  } while (false)
