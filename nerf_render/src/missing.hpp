#pragma once

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace deja_view::nerf::internal {

/// Names of what a data set lacks, for one error.
class Missing {
 public:
  void Add(std::string name) { names_.push_back(std::move(name)); }
  std::size_t size() const { return names_.size(); }

  /// Throws InputError "where: 3 of 20 images have no pose (a.png, b.png, c.png)" when something is
  /// missing, unless `skip` allows it and something is left.
  void Check(bool skip, const std::string& where, std::size_t total, const char* what) const {
    constexpr std::size_t kShown = 3;
    if (names_.empty() || (skip && names_.size() < total)) {
      return;
    }
    const std::vector<std::string> first(
        names_.begin(),
        names_.begin() + static_cast<std::ptrdiff_t>(std::min(kShown, names_.size())));
    ThrowInputError("{}: {} of {} {} ({}{}){}",
                    where,
                    names_.size(),
                    total,
                    what,
                    fmt::join(first, ", "),
                    names_.size() > kShown ? ", ..." : "",
                    skip ? "" : ": expected all, unless missing ones are to be skipped");
  }

 private:
  std::vector<std::string> names_;
};

}  // namespace deja_view::nerf::internal
