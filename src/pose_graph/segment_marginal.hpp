#pragma once

#include "deja_view/pose_graph/four_dof_error.hpp"
#include "deja_view/pose_graph/pose_graph_parts.hpp"

#include <cstddef>
#include <vector>

namespace deja_view {

/// Nodes that are dropped together, a stretch of a flight, and all that is measured between them
/// and the nodes around them.
struct Segment {
  struct Node {
    int id = -1;
    PoseGraphNode node;
    bool is_dropped = false;
  };
  struct Edge {
    std::size_t from = 0;  ///< indices of `nodes`
    std::size_t to = 0;
    FourDofError::Measurement measurement;
  };
  std::vector<Node> nodes;
  std::vector<Edge> edges;  ///< connect all nodes
};

/// What the nodes around a segment know of each other when it is gone: the exact marginal, to first
/// order about the present state, approximated once. Of all trees over these nodes it is the one
/// with most information (Chow and Liu 1968), each tie with mean and covariance as the marginal has
/// them. Dropping node by node would approximate again and again. Fixed nodes count as one.
std::vector<PoseGraphTie> Marginalise(const Segment& segment);

}  // namespace deja_view
