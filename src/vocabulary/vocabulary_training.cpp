#include "deja_view/vocabulary/vocabulary_training.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "kmeans.hpp"

namespace deja_view {
namespace {

// From this size on all threads work on one node; below, each has nodes of its own.
constexpr std::size_t kBigNode = 65536;

struct Node {
  Descriptor centre;
  int parent = -1;
  int level = 0;
  std::size_t begin = 0;  // descriptors [begin, end)
  std::size_t end = 0;
  std::vector<int> children;

  std::size_t size() const { return end - begin; }
};

class Trainer {
 public:
  Trainer(const std::vector<std::vector<Descriptor>>& images, const TrainOptions& options)
      : options_(options) {
    std::size_t count = 0;
    for (const auto& image : images) {
      count += image.size();
    }
    descriptors_.reserve(count);
    for (const auto& image : images) {
      descriptors_.insert(descriptors_.end(), image.begin(), image.end());
    }
    nodes_.emplace_back();
    nodes_[0].end = count;
  }

  void Grow(const TrainProgress& progress) {
    std::size_t done = 0;
    for (std::vector<int> round = NextRound(); !round.empty(); round = NextRound()) {
      Split(round);
      done += round.size();
      if (progress) {
        progress(done, done + open_.size());
      }
    }
  }

  // Nodes breadth first, so that they are in the order of our own files; words in the same order.
  VocabularyTree Tree() const {
    VocabularyTree tree;
    tree.k = options_.k;
    tree.levels = options_.levels;
    tree.descriptor_name = options_.descriptor_name;
    std::vector<int> order = nodes_[0].children;
    std::vector<std::int32_t> parents(order.size(), VocabularyNode::kRoot);
    std::int32_t words = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
      const Node& node = nodes_[order[i]];
      VocabularyNode out;
      out.id = static_cast<std::int32_t>(i + 1);
      out.parent = parents[i];
      out.word = node.children.empty() ? words++ : VocabularyNode::kNoWord;
      out.descriptor = node.centre;
      tree.nodes.push_back(out);
      order.insert(order.end(), node.children.begin(), node.children.end());
      parents.resize(order.size(), static_cast<std::int32_t>(i));
    }
    return tree;
  }

 private:
  // The nodes to split next, in the order in which they came to be.
  std::vector<int> NextRound() {
    if (nodes_.size() == 1) {
      return {0};
    }
    std::size_t fullest = 0;
    for (const int node : open_) {
      fullest = std::max(fullest, nodes_[node].size());
    }
    const auto limit = options_.max_words > 0 ? static_cast<std::size_t>(options_.max_words)
                                              : std::numeric_limits<std::size_t>::max();
    std::vector<int> round;
    std::vector<int> rest;
    std::size_t words = words_;
    for (const int node : open_) {
      const bool is_full = options_.max_words == 0 || 2 * nodes_[node].size() > fullest;
      const std::size_t more = static_cast<std::size_t>(options_.k) - 1;
      if (is_full && more <= limit && words <= limit - more) {
        words += more;
        round.push_back(node);
      } else {
        rest.push_back(node);
      }
    }
    open_ = std::move(rest);
    return round;
  }

  void Split(const std::vector<int>& round) {
    std::vector<std::vector<internal::Cluster>> clusters(round.size());
    std::vector<std::size_t> small;
    for (std::size_t i = 0; i < round.size(); ++i) {
      if (nodes_[round[i]].size() >= kBigNode) {
        clusters[i] = Cluster(round[i], options_.threads);
      } else {
        small.push_back(i);
      }
    }
    ParallelFor(options_.threads, small.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        clusters[small[i]] = Cluster(round[small[i]], 1);
      }
    });
    for (std::size_t i = 0; i < round.size(); ++i) {
      AddChildren(round[i], clusters[i]);
    }
  }

  std::vector<internal::Cluster> Cluster(int node, int threads) {
    internal::KMeansOptions options;
    options.k = options_.k;
    options.iterations = options_.iterations;
    options.threads = threads;
    // Where a node's descriptors begin tells nodes of one level apart, and levels differ
    // themselves.
    options.seed = (std::uint64_t{options_.seed} << 32U) + nodes_[node].begin * 64 +
                   static_cast<std::uint64_t>(nodes_[node].level);
    return internal::KMeans(options, descriptors_.data() + nodes_[node].begin, nodes_[node].size());
  }

  void AddChildren(int parent, const std::vector<internal::Cluster>& clusters) {
    if (clusters.size() < 2 && parent != 0) {
      return;  // all equal: the node stays a leaf
    }
    for (const internal::Cluster& cluster : clusters) {
      Node child;
      child.centre = cluster.centre;
      child.parent = parent;
      child.level = nodes_[parent].level + 1;
      child.begin = nodes_[parent].begin + cluster.begin;
      child.end = nodes_[parent].begin + cluster.end;
      const int index = static_cast<int>(nodes_.size());
      if (child.level < options_.levels && child.size() > 1) {
        open_.push_back(index);
      }
      nodes_[parent].children.push_back(index);
      nodes_.push_back(std::move(child));
    }
    words_ += clusters.size() - (parent == 0 ? 0 : 1);
  }

  const TrainOptions& options_;
  std::vector<Descriptor> descriptors_;
  std::vector<Node> nodes_;  // [0] is the root
  std::vector<int> open_;    // leaves that may still be split
  std::size_t words_ = 0;
};

// idf = log(images / images with the word), from the words that a descent finds.
void SetWeights(const std::vector<std::vector<Descriptor>>& images,
                int threads,
                VocabularyTree* tree) {
  const auto vocabulary = Vocabulary::FromTree(*tree);
  std::vector<std::uint32_t> with_word(vocabulary->word_count(), 0);
  std::mutex mutex;
  ParallelFor(threads, images.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const BowVector bow = vocabulary->Bag(images[i]);
      const std::lock_guard<std::mutex> lock(mutex);
      for (const WordCount& entry : bow.entries) {
        ++with_word[entry.word];
      }
    }
  });
  for (VocabularyNode& node : tree->nodes) {
    if (node.word != VocabularyNode::kNoWord) {
      const double with = std::max<std::uint32_t>(1, with_word[node.word]);
      // Rounded to what our own files hold.
      node.weight = static_cast<float>(std::log(static_cast<double>(images.size()) / with));
    }
  }
}

}  // namespace

std::vector<std::string> TrainOptions::Validate() const {
  Requirements r;
  r.Range("k", k, 2, 255);
  r.Range("levels", levels, 1, 32);
  r.Range("max_words", max_words, 0, 1 << 30);
  r.Range("iterations", iterations, 1, 1000);
  r.Range("threads", threads, 0, 1024);
  r.That(descriptor_name == "brief" || descriptor_name == "orb",
         "descriptor",
         descriptor_name,
         "brief or orb");
  return r.errors();
}

VocabularyTree TrainVocabulary(const std::vector<std::vector<Descriptor>>& images,
                               const TrainOptions& options,
                               const TrainProgress& progress) {
  CheckNone(options.Validate(), "vocabulary training");
  if (std::all_of(images.begin(), images.end(), [](const auto& image) { return image.empty(); })) {
    ThrowInputError("vocabulary training: no descriptor in {} images", images.size());
  }
  Trainer trainer(images, options);
  trainer.Grow(progress);
  VocabularyTree tree = trainer.Tree();
  SetWeights(images, options.threads, &tree);
  return tree;
}

}  // namespace deja_view
