#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace deja_view {

/// Text of a file, a message or a user as it may stand in a message of ours: in single quotes,
/// control characters as \n, \t or \x1b, and of more than `max_bytes` the beginning with what is
/// left out: 'abc...' (2000 bytes).
std::string Quote(std::string_view text, std::size_t max_bytes = 64);

}  // namespace deja_view
