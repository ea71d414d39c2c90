#pragma once

#include <string>

namespace deja_view::report {

/// Bytes in base 64 (RFC 4648), as data addresses want them.
std::string Base64(const std::string& bytes);

}  // namespace deja_view::report
