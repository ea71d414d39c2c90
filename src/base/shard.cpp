#include "deja_view/base/shard.hpp"

#include "deja_view/base/check.hpp"

#include <cstdio>

namespace deja_view {

Shard ParseShard(const std::string& option, const std::string& text) {
  Shard shard;
  int length = 0;
  const int found = std::sscanf(text.c_str(), "%d/%d%n", &shard.index, &shard.count, &length);
  if (found != 2 || static_cast<std::size_t>(length) != text.size() || shard.count < 1 ||
      shard.count > 100000 || shard.index < 0 || shard.index >= shard.count) {
    ThrowInputError("{} {}: expected i/n with i from 0 to n - 1", option, text);
  }
  return shard;
}

}  // namespace deja_view
