#include "deja_view/base/quote.hpp"

#include <fmt/format.h>

namespace deja_view {
namespace {

bool IsUtf8Continuation(char c) {
  return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;
}

void AppendPrintable(char c, std::string* text) {
  const auto byte = static_cast<unsigned char>(c);
  if (c == '\n') {
    *text += "\\n";
  } else if (c == '\t') {
    *text += "\\t";
  } else if (byte < 0x20 || byte == 0x7F) {
    *text += fmt::format("\\x{:02x}", byte);
  } else {
    *text += c;
  }
}

}  // namespace

std::string Quote(std::string_view text, std::size_t max_bytes) {
  std::size_t shown = text.size();
  if (shown > max_bytes) {
    shown = max_bytes;
    while (shown > 0 && IsUtf8Continuation(text[shown])) {
      --shown;
    }
  }
  std::string quoted = "'";
  for (const char c : text.substr(0, shown)) {
    AppendPrintable(c, &quoted);
  }
  return shown == text.size() ? quoted + "'"
                              : fmt::format("{}...' ({} bytes)", quoted, text.size());
}

}  // namespace deja_view
