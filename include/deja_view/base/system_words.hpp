#pragma once

#include <cerrno>
#include <string>
#include <system_error>

namespace deja_view {

/// What the system says of a call that failed; unlike strerror from any thread.
inline std::string SystemsWords(int error = errno) {
  return std::generic_category().message(error);
}

}  // namespace deja_view
