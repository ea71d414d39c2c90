#include "track_builder.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <unordered_map>
#include <utility>

namespace deja_view::internal {
namespace {

/// Disjoint sets of nodes, of which none holds two nodes of an image.
class ImageSets {
 public:
  explicit ImageSets(std::vector<int> image_of_node)
      : image_of_node_(std::move(image_of_node)),
        root_(image_of_node_.size()),
        members_(image_of_node_.size()) {
    for (std::size_t i = 0; i < root_.size(); ++i) {
      root_[i] = static_cast<int>(i);
      members_[i] = {static_cast<int>(i)};
    }
  }

  void Join(int a, int b) {
    int into = root_[static_cast<std::size_t>(a)];
    int from = root_[static_cast<std::size_t>(b)];
    if (into == from) {
      return;
    }
    std::vector<int>* kept = &members_[static_cast<std::size_t>(into)];
    std::vector<int>* joined = &members_[static_cast<std::size_t>(from)];
    if (kept->size() < joined->size()) {
      std::swap(into, from);
      std::swap(kept, joined);
    }
    if (!ShareImage(*kept, *joined)) {
      for (const int node : *joined) {
        root_[static_cast<std::size_t>(node)] = into;
      }
      std::vector<int> all;
      std::merge(
          kept->begin(), kept->end(), joined->begin(), joined->end(), std::back_inserter(all));
      *kept = std::move(all);
      joined->clear();
    }
  }

  const std::vector<std::vector<int>>& members() const { return members_; }

 private:
  /// Nodes ascend with their images.
  bool ShareImage(const std::vector<int>& a, const std::vector<int>& b) const {
    auto i = a.begin();
    auto j = b.begin();
    while (i != a.end() && j != b.end()) {
      const int image_i = image_of_node_[static_cast<std::size_t>(*i)];
      const int image_j = image_of_node_[static_cast<std::size_t>(*j)];
      if (image_i == image_j) {
        return true;
      }
      ++(image_i < image_j ? i : j);
    }
    return false;
  }

  std::vector<int> image_of_node_;
  std::vector<int> root_;
  std::vector<std::vector<int>> members_;  ///< of each root, ascending
};

}  // namespace

std::vector<Track> BuildTracks(const BundleProblem& problem,
                               const std::vector<KeypointMatch>& matches) {
  std::vector<int> first_node;
  std::vector<int> image_of_node;
  for (std::size_t i = 0; i < problem.images.size(); ++i) {
    first_node.push_back(static_cast<int>(image_of_node.size()));
    image_of_node.insert(
        image_of_node.end(), problem.images[i].keypoints.size(), static_cast<int>(i));
  }
  ImageSets sets(image_of_node);
  std::unordered_map<std::int64_t, int> newest;  // node of each of the VIO's tracks
  for (std::size_t i = 0; i < problem.images.size(); ++i) {
    const std::vector<std::int64_t>& ids = problem.images[i].track_ids;
    for (std::size_t k = 0; k < ids.size(); ++k) {
      if (ids[k] >= 0) {
        const int node = first_node[i] + static_cast<int>(k);
        const auto [entry, is_new] = newest.emplace(ids[k], node);
        if (!is_new) {
          sets.Join(entry->second, node);
          entry->second = node;
        }
      }
    }
  }
  std::vector<std::size_t> order(matches.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = i;
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return matches[a].distance < matches[b].distance;
  });
  const auto node = [&](const BundleObservation& o) {
    return first_node[static_cast<std::size_t>(o.image)] + o.keypoint;
  };
  for (const std::size_t i : order) {
    sets.Join(node(matches[i].a), node(matches[i].b));
  }
  std::vector<Track> tracks;
  for (const std::vector<int>& members : sets.members()) {
    if (members.size() >= 2) {
      Track track;
      for (const int member : members) {
        const int image = image_of_node[static_cast<std::size_t>(member)];
        track.push_back({image, member - first_node[static_cast<std::size_t>(image)]});
      }
      tracks.push_back(std::move(track));
    }
  }
  std::sort(tracks.begin(), tracks.end(), [](const Track& a, const Track& b) {
    return std::make_pair(a.front().image, a.front().keypoint) <
           std::make_pair(b.front().image, b.front().keypoint);
  });
  return tracks;
}

}  // namespace deja_view::internal
