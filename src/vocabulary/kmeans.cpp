#include "kmeans.hpp"

#include "deja_view/base/parallel.hpp"
#include "deja_view/base/random.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "bit_counter.hpp"
#include "descend.hpp"

namespace deja_view::internal {
namespace {

// Descriptors are counted in chunks of this size, whatever the number of threads.
constexpr std::size_t kChunk = 8192;

// Descriptors to choose the next centre from.
constexpr int kCandidates = 4;

class Problem {
 public:
  Problem(const KMeansOptions& options, const Descriptor* descriptors, std::size_t count)
      : options_(options),
        descriptors_(descriptors),
        count_(count),
        kernel_(ChooseDescendKernel()),
        labels_(count, 0) {}

  // Greedy k-means++: of a few descriptors, drawn with a probability proportional to their squared
  // distance (of binary vectors: Hamming distance) from the centres so far, the one that lowers the
  // sum of distances most becomes the next centre.
  void Seed() {
    Random random(options_.seed);
    std::vector<std::uint16_t> distances(count_, 0xffffU);
    centres_.push_back(descriptors_[random.Below(count_)]);
    Lower(centres_.back(), &distances);
    while (centres_.size() < static_cast<std::size_t>(options_.k)) {
      const std::uint64_t total = Sum(distances);
      if (total == 0) {
        return;
      }
      std::vector<std::uint16_t> best;
      std::uint64_t best_total = ~std::uint64_t{0};
      std::size_t best_index = 0;
      for (int i = 0; i < kCandidates; ++i) {
        const std::size_t index = Draw(distances, random.Below(total));
        std::vector<std::uint16_t> lowered = distances;
        Lower(descriptors_[index], &lowered);
        const std::uint64_t lowered_total = Sum(lowered);
        if (lowered_total < best_total) {
          best_total = lowered_total;
          best_index = index;
          best = std::move(lowered);
        }
      }
      centres_.push_back(descriptors_[best_index]);
      distances = std::move(best);
    }
  }

  void Assign() {
    ParallelFor(
        Threads(),
        count_,
        [&](std::size_t begin, std::size_t end) {
          kernel_.assign(descriptors_ + begin,
                         end - begin,
                         centres_.data(),
                         static_cast<std::uint32_t>(centres_.size()),
                         labels_.data() + begin);
        },
        kChunk);
  }

  // Moves the centres to their descriptors' majority, dropping those without any; false when none
  // moved.
  bool Update() {
    const std::size_t chunks = (count_ + kChunk - 1) / kChunk;
    std::vector<std::vector<BitCounter>> partial(chunks);
    ParallelFor(Threads(), chunks, [&](std::size_t begin, std::size_t end) {
      for (std::size_t chunk = begin; chunk < end; ++chunk) {
        partial[chunk].resize(centres_.size());
        const std::size_t last = std::min(count_, (chunk + 1) * kChunk);
        for (std::size_t i = chunk * kChunk; i < last; ++i) {
          partial[chunk][labels_[i]].Add(descriptors_[i]);
        }
      }
    });
    std::vector<Descriptor> moved;
    for (std::size_t c = 0; c < centres_.size(); ++c) {
      BitCounter sum;
      for (const std::vector<BitCounter>& counters : partial) {
        sum.Add(counters[c]);
      }
      if (sum.count() > 0) {
        moved.push_back(sum.Majority());
      }
    }
    const bool has_moved = moved != centres_;
    centres_ = std::move(moved);
    return has_moved;
  }

  // Clusters in the order of their centres; descriptors are moved to `sorted`.
  std::vector<Cluster> Sort(std::vector<Descriptor>* sorted) const {
    std::vector<std::size_t> sizes(centres_.size(), 0);
    for (const std::uint8_t label : labels_) {
      ++sizes[label];
    }
    std::vector<Cluster> clusters;
    std::vector<std::size_t> next(centres_.size());
    std::size_t begin = 0;
    for (std::size_t c = 0; c < centres_.size(); ++c) {
      next[c] = begin;
      if (sizes[c] > 0) {
        clusters.push_back({centres_[c], begin, begin + sizes[c]});
      }
      begin += sizes[c];
    }
    sorted->resize(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      (*sorted)[next[labels_[i]]++] = descriptors_[i];
    }
    return clusters;
  }

 private:
  static std::uint64_t Sum(const std::vector<std::uint16_t>& distances) {
    return std::accumulate(distances.begin(), distances.end(), std::uint64_t{0});
  }

  // The index at which the running sum of distances passes `position`.
  static std::size_t Draw(const std::vector<std::uint16_t>& distances, std::uint64_t position) {
    std::size_t index = 0;
    while (position >= distances[index]) {
      position -= distances[index++];
    }
    return index;
  }

  void Lower(const Descriptor& centre, std::vector<std::uint16_t>* distances) const {
    ParallelFor(
        Threads(),
        count_,
        [&](std::size_t begin, std::size_t end) {
          kernel_.lower(descriptors_ + begin, end - begin, centre, distances->data() + begin);
        },
        kChunk);
  }

  int Threads() const { return count_ < 2 * kChunk ? 1 : options_.threads; }

  const KMeansOptions& options_;
  const Descriptor* descriptors_;
  std::size_t count_;
  DescendKernel kernel_;
  std::vector<Descriptor> centres_;
  std::vector<std::uint8_t> labels_;
};

}  // namespace

std::vector<Cluster> KMeans(const KMeansOptions& options,
                            Descriptor* descriptors,
                            std::size_t count) {
  Problem problem(options, descriptors, count);
  problem.Seed();
  problem.Assign();
  for (int i = 0; i < options.iterations && problem.Update(); ++i) {
    problem.Assign();
  }
  std::vector<Descriptor> sorted;
  std::vector<Cluster> clusters = problem.Sort(&sorted);
  std::copy(sorted.begin(), sorted.end(), descriptors);
  return clusters;
}

}  // namespace deja_view::internal
