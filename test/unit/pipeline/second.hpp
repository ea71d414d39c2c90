#pragma once

#include <cstdint>

namespace deja_view {

inline constexpr std::int64_t kSecond = 1'000'000'000;  ///< [ns]

}  // namespace deja_view
