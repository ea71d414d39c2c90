#pragma once

#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace deja_view {

/// What the call throws, or "no error".
template <typename Error, typename Call>
std::string MessageOf(Call call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

/// Matches a message that has all of these parts.
template <typename... Part>
auto Says(const Part&... parts) {
  return ::testing::AllOf(::testing::HasSubstr(parts)...);
}

/// `error_of` each of these texts says what stands beside it.
template <typename ErrorOf>
void ExpectErrors(const ErrorOf& error_of,
                  const std::vector<std::pair<std::string, std::string>>& cases) {
  for (const auto& [text, message] : cases) {
    EXPECT_THAT(error_of(text), Says(message)) << text;
  }
}

}  // namespace deja_view
