#pragma once

#include <string>

namespace deja_view {

/// One of `count` shares of some work.
struct Shard {
  int index = 0;  ///< from 0
  int count = 1;

  bool operator==(const Shard& o) const { return index == o.index && count == o.count; }
  bool operator!=(const Shard& o) const { return !(*this == o); }
};

/// Reads "i/n" with i from 0 to n - 1, n at most 100000. Throws InputError that names `option`.
Shard ParseShard(const std::string& option, const std::string& text);

}  // namespace deja_view
