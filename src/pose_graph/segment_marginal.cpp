#include "segment_marginal.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace deja_view {
namespace {

using Eigen::Matrix4d;
using Eigen::MatrixXd;
using Eigen::Vector4d;
using Eigen::VectorXd;

constexpr Eigen::Index kDof = 4;

/// psi [rad] and t_M [m] of a node.
struct State {
  double psi = 0;
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
};

/// A residual with its derivatives by the states (psi, t) of both nodes.
struct Linear {
  Vector4d r;
  Matrix4d J_i, J_j;
};

Linear Linearise(const FourDofError::Measurement& measurement, const State& i, const State& j) {
  using Jacobian43 = Eigen::Matrix<double, 4, 3, Eigen::RowMajor>;
  Vector4d by_psi_i;
  Vector4d by_psi_j;
  Jacobian43 by_t_i;
  Jacobian43 by_t_j;
  const std::array<const double*, 4> parameters = {&i.psi, i.t.data(), &j.psi, j.t.data()};
  std::array<double*, 4> jacobians = {
      by_psi_i.data(), by_t_i.data(), by_psi_j.data(), by_t_j.data()};
  Linear linear;
  FourDofError(measurement).Evaluate(parameters.data(), linear.r.data(), jacobians.data());
  linear.J_i << by_psi_i, by_t_i;
  linear.J_j << by_psi_j, by_t_j;
  return linear;
}

/// A node beside the segment, in the marginal.
struct Leaf {
  const Segment::Node* node = nullptr;
  State mean;
  Eigen::Index row = -1;  ///< of the covariance; -1: it is held
};

struct Marginal {
  std::vector<Leaf> leaves;
  MatrixXd covariance;  ///< of (psi, t) of all leaves that are not held

  Matrix4d Block(const Leaf& a, const Leaf& b) const {
    return a.row < 0 || b.row < 0 ? Matrix4d(Matrix4d::Zero())
                                  : Matrix4d(covariance.block<kDof, kDof>(a.row, b.row));
  }
};

/// Rows of the nodes in the normal equations, those dropped first; -1 for nodes that are held: the
/// fixed ones or, where there are none, one of those that stay.
struct Layout {
  std::vector<Eigen::Index> rows;
  Eigen::Index dropped = 0;  ///< rows of these
  Eigen::Index size = 0;
  std::size_t held = 0;  ///< a node that is held
};

Layout MakeLayout(const Segment& segment) {
  Layout layout;
  const auto is_fixed = [](const Segment::Node& node) { return node.node.is_fixed; };
  const auto stays = [](const Segment::Node& node) { return !node.is_dropped; };
  const auto& nodes = segment.nodes;
  const auto fixed = std::find_if(nodes.begin(), nodes.end(), is_fixed);
  const auto held = fixed != nodes.end() ? fixed : std::find_if(nodes.begin(), nodes.end(), stays);
  layout.held = static_cast<std::size_t>(held - nodes.begin());
  layout.rows.assign(nodes.size(), -1);
  for (const bool is_dropped : {true, false}) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i].is_dropped == is_dropped && !nodes[i].node.is_fixed && i != layout.held) {
        layout.rows[i] = layout.size;
        layout.size += kDof;
      }
    }
    layout.dropped = is_dropped ? layout.size : layout.dropped;
  }
  return layout;
}

Marginal Eliminate(const Segment& segment) {
  const Layout layout = MakeLayout(segment);
  MatrixXd H = MatrixXd::Zero(layout.size, layout.size);
  VectorXd g = VectorXd::Zero(layout.size);
  const auto state = [&](std::size_t i) {
    return State{segment.nodes[i].node.psi, segment.nodes[i].node.t_M_B};
  };
  for (const Segment::Edge& edge : segment.edges) {
    const Linear linear = Linearise(edge.measurement, state(edge.from), state(edge.to));
    const Eigen::Index i = layout.rows[edge.from];
    const Eigen::Index j = layout.rows[edge.to];
    if (i >= 0) {
      H.block<kDof, kDof>(i, i) += linear.J_i.transpose() * linear.J_i;
      g.segment<kDof>(i) += linear.J_i.transpose() * linear.r;
    }
    if (j >= 0) {
      H.block<kDof, kDof>(j, j) += linear.J_j.transpose() * linear.J_j;
      g.segment<kDof>(j) += linear.J_j.transpose() * linear.r;
    }
    if (i >= 0 && j >= 0) {
      H.block<kDof, kDof>(i, j) += linear.J_i.transpose() * linear.J_j;
      H.block<kDof, kDof>(j, i) += linear.J_j.transpose() * linear.J_i;
    }
  }
  const Eigen::Index d = layout.dropped;
  const Eigen::Index b = layout.size - d;
  const Eigen::LLT<MatrixXd> dropped(H.topLeftCorner(d, d));
  const MatrixXd solved = dropped.solve(H.topRightCorner(d, b));
  const MatrixXd information = H.bottomRightCorner(b, b) - H.bottomLeftCorner(b, d) * solved;
  const VectorXd gradient = g.tail(b) - solved.transpose() * g.head(d);
  Marginal marginal;
  marginal.covariance = information.llt().solve(MatrixXd::Identity(b, b));
  const VectorXd step = -(marginal.covariance * gradient);
  for (std::size_t i = 0; i < segment.nodes.size(); ++i) {
    if (segment.nodes[i].is_dropped || (layout.rows[i] < 0 && i != layout.held)) {
      continue;
    }
    Leaf leaf{&segment.nodes[i], state(i), layout.rows[i] < 0 ? -1 : layout.rows[i] - d};
    if (leaf.row >= 0) {
      leaf.mean.psi += step[leaf.row];
      leaf.mean.t += step.segment<3>(leaf.row + 1);
    }
    marginal.leaves.push_back(leaf);
  }
  return marginal;
}

PoseGraphTie MakeTie(const Marginal& marginal, const Leaf& a, const Leaf& b) {
  const bool is_ordered = a.node->id < b.node->id;
  const Leaf& i = is_ordered ? a : b;
  const Leaf& j = is_ordered ? b : a;
  FourDofError::Measurement m;
  m.R_W_I = i.node->node.T_W_B.R();
  m.t_I_J = m.R_W_I.transpose() * (FromYaw(-i.mean.psi) * (j.mean.t - i.mean.t));
  m.delta_psi = WrapAngle(j.mean.psi - i.mean.psi);
  const Linear linear = Linearise(m, i.mean, j.mean);
  const Matrix4d cross = linear.J_i * marginal.Block(i, j) * linear.J_j.transpose();
  const Matrix4d covariance = linear.J_i * marginal.Block(i, i) * linear.J_i.transpose() +
                              linear.J_j * marginal.Block(j, j) * linear.J_j.transpose() + cross +
                              cross.transpose();
  PoseGraphTie tie;
  tie.from = i.node->id;
  tie.to = j.node->id;
  tie.t_I_J = m.t_I_J;
  tie.delta_psi = m.delta_psi;
  tie.information = covariance.ldlt().solve(Matrix4d::Identity());
  tie.information = 0.5 * (tie.information + tie.information.transpose().eval());
  return tie;
}

}  // namespace

// Prim's algorithm.
std::vector<PoseGraphTie> Marginalise(const Segment& segment) {
  struct Best {
    double information = -std::numeric_limits<double>::infinity();
    PoseGraphTie tie;
    bool is_in = false;
  };
  const Marginal marginal = Eliminate(segment);
  const std::vector<Leaf>& leaves = marginal.leaves;
  std::vector<Best> best(leaves.size());
  std::vector<PoseGraphTie> tree;
  std::size_t newest = 0;
  for (std::size_t count = 1; count < leaves.size(); ++count) {
    best[newest].is_in = true;
    std::size_t next = leaves.size();
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      if (best[i].is_in) {
        continue;
      }
      const PoseGraphTie tie = MakeTie(marginal, leaves[newest], leaves[i]);
      const double information =
          std::log(std::max(std::numeric_limits<double>::min(), tie.information.determinant()));
      if (information > best[i].information) {
        best[i].information = information;
        best[i].tie = tie;
      }
      if (next == leaves.size() || best[i].information > best[next].information) {
        next = i;
      }
    }
    tree.push_back(best[next].tie);
    newest = next;
  }
  return tree;
}

}  // namespace deja_view
