#pragma once

#include "deja_view/features/types.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace deja_view::internal {

struct KMeansOptions {
  int k = 10;  ///< 2 to 255
  int iterations = 12;
  std::uint64_t seed = 1;
  int threads = 1;  ///< no influence on the result
};

/// One part of the data around its centre.
struct Cluster {
  Descriptor centre;
  std::size_t begin = 0;  ///< the cluster's descriptors are [begin, end) after the call
  std::size_t end = 0;
};

/// Clusters `count` descriptors by k-means in Hamming space and sorts them by cluster, keeping
/// their order within each. Every descriptor is with its nearest centre, the first of equally near
/// ones. Returns at most k clusters, none empty; a single one when all descriptors are equal.
std::vector<Cluster> KMeans(const KMeansOptions& options,
                            Descriptor* descriptors,
                            std::size_t count);

}  // namespace deja_view::internal
