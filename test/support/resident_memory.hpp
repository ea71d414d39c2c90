#pragma once

#include <fstream>
#include <string>

namespace deja_view::test {

/// What this process holds in memory now [kB]; 0 where the system does not tell.
inline double ResidentKb() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    if (word == "VmRSS:") {
      double kb = 0;
      status >> kb;
      return kb;
    }
  }
  return 0;
}

}  // namespace deja_view::test
