#include "deja_view/pose_graph/pose_graph.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/pose_graph/four_dof_error.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

namespace deja_view {
namespace {

/// L with L^T L = covariance^-1.
Eigen::Matrix4d SqrtInformation(const Eigen::Matrix4d& covariance) {
  const Eigen::Matrix4d information = covariance.ldlt().solve(Eigen::Matrix4d::Identity());
  return information.llt().matrixU();
}

}  // namespace

std::vector<std::string> PoseGraphOptions::Validate() const {
  Requirements r;
  r.That(odometry_sigma_floor_m > 0, "odometry_sigma_floor_m must be positive");
  r.That(odometry_sigma_per_sqrt_m >= 0, "odometry_sigma_per_sqrt_m must not be negative");
  r.That(odometry_yaw_sigma_floor_deg > 0, "odometry_yaw_sigma_floor_deg must be positive");
  r.That(odometry_yaw_sigma_per_sqrt_m_deg >= 0,
         "odometry_yaw_sigma_per_sqrt_m_deg must not be negative");
  r.That(loop_sigma_floor_m > 0, "loop_sigma_floor_m must be positive");
  r.That(loop_scale_sigma >= 0, "loop_scale_sigma must not be negative");
  r.That(loop_sigma_per_m >= 0, "loop_sigma_per_m must not be negative");
  r.That(loop_yaw_sigma_floor_deg > 0, "loop_yaw_sigma_floor_deg must be positive");
  r.That(kernel_scale > 0, "kernel_scale must be positive");
  r.That(kernel_graduation > 1, "kernel_graduation must be above 1");
  r.That(max_iterations > 0, "max_iterations must be positive");
  return r.errors();
}

PoseGraph PoseGraph::FromParts(const PoseGraphOptions& options,
                               std::vector<PoseGraphNode> nodes,
                               std::vector<PoseGraphLoop> loops) {
  PoseGraph graph(options);
  for (PoseGraphNode& node : nodes) {
    const int index = graph.AddNode(node.sequence, node.T_W_B, node.is_fixed);
    graph.nodes_[static_cast<std::size_t>(index)] = node;
  }
  for (PoseGraphLoop& loop : loops) {
    DEJA_VIEW_CHECK(loop.from >= 0 && loop.from < graph.size());
    DEJA_VIEW_CHECK(loop.to >= 0 && loop.to < graph.size());
    const int a = graph.Group(graph.nodes_[static_cast<std::size_t>(loop.from)].sequence);
    const int b = graph.Group(graph.nodes_[static_cast<std::size_t>(loop.to)].sequence);
    std::replace(graph.group_.begin(), graph.group_.end(), std::max(a, b), std::min(a, b));
    graph.loops_.push_back(std::move(loop));
  }
  return graph;
}

int PoseGraph::AddNode(int sequence, const Rigid3& T_W_B, bool is_fixed) {
  DEJA_VIEW_CHECK_OP(sequence, >=, 0);
  PoseGraphNode node;
  node.sequence = sequence;
  node.is_fixed = is_fixed;
  node.T_W_B = T_W_B;
  node.t_M_B = T_W_B.t;
  double path = 0;
  if (!nodes_.empty() && nodes_.back().sequence == sequence) {
    const Rigid3 T_M_W = Correction(size() - 1);
    node.psi = nodes_.back().psi;
    node.t_M_B = T_M_W * T_W_B.t;
    path = path_.back() + (T_W_B.t - nodes_.back().T_W_B.t).norm();
  }
  while (static_cast<int>(group_.size()) <= sequence) {
    group_.push_back(static_cast<int>(group_.size()));
  }
  nodes_.push_back(node);
  path_.push_back(path);
  return size() - 1;
}

Rigid3 PoseGraph::Correction(int node) const {
  const PoseGraphNode& n = nodes_.at(static_cast<std::size_t>(node));
  const Eigen::Quaterniond q = FromYaw(n.psi);
  return {q, n.t_M_B - q * n.T_W_B.t};
}

int PoseGraph::Group(int sequence) const {
  return group_.at(static_cast<std::size_t>(sequence));
}

bool PoseGraph::IsAnchored(int sequence) const {
  return !nodes_.empty() && Group(sequence) == Group(nodes_.front().sequence);
}

double PoseGraph::PathLength(int from, int to) const {
  return std::abs(path_.at(static_cast<std::size_t>(to)) -
                  path_.at(static_cast<std::size_t>(from)));
}

void PoseGraph::AddLoop(const PoseGraphLoop& loop) {
  DEJA_VIEW_CHECK(loop.from >= 0 && loop.from < size());
  DEJA_VIEW_CHECK(loop.to >= 0 && loop.to < size());
  const auto& from = nodes_[static_cast<std::size_t>(loop.from)];
  const auto& to = nodes_[static_cast<std::size_t>(loop.to)];
  if (Group(from.sequence) != Group(to.sequence)) {
    JoinGroups(loop);
  }
  loops_.push_back(loop);
}

bool PoseGraph::UpdateLoop(int from, int to, const Rigid3& T_from_to) {
  const auto it = std::find_if(loops_.rbegin(), loops_.rend(), [&](const PoseGraphLoop& loop) {
    return loop.from == from && loop.to == to;
  });
  if (it == loops_.rend()) {
    return false;
  }
  it->T_from_to = T_from_to;
  return true;
}

void PoseGraph::JoinGroups(const PoseGraphLoop& loop) {
  const PoseGraphNode& from = nodes_[static_cast<std::size_t>(loop.from)];
  const PoseGraphNode& to = nodes_[static_cast<std::size_t>(loop.to)];
  const int from_group = Group(from.sequence);
  const int to_group = Group(to.sequence);
  const bool moves_to = from_group < to_group;
  const int kept = std::min(from_group, to_group);
  const int moved = std::max(from_group, to_group);
  // Where the loop puts the moved end, against where it is now.
  const PoseGraphNode& end = moves_to ? to : from;
  const Rigid3 T_M_end =
      moves_to ? from.T_M_B() * loop.T_from_to : to.T_M_B() * loop.T_from_to.Inverse();
  const double yaw =
      ToYawTransform({T_M_end.q * end.T_M_B().q.conjugate(), Eigen::Vector3d::Zero()}).yaw;
  const Eigen::Quaterniond q = FromYaw(yaw);
  const Eigen::Vector3d t = T_M_end.t - q * end.t_M_B;
  for (PoseGraphNode& node : nodes_) {
    if (Group(node.sequence) == moved) {
      node.psi = WrapAngle(node.psi + yaw);
      node.t_M_B = q * node.t_M_B + t;
    }
  }
  std::replace(group_.begin(), group_.end(), moved, kept);
}

Eigen::Matrix4d PoseGraph::OdometrySqrtInformation(double distance) const {
  const double root = std::sqrt(distance);
  const double sigma_t =
      std::hypot(options_.odometry_sigma_floor_m, options_.odometry_sigma_per_sqrt_m * root);
  const double sigma_psi = kDegree * std::hypot(options_.odometry_yaw_sigma_floor_deg,
                                                options_.odometry_yaw_sigma_per_sqrt_m_deg * root);
  Eigen::Matrix4d L = Eigen::Matrix4d::Zero();
  L.diagonal() << 1 / sigma_t, 1 / sigma_t, 1 / sigma_t, 1 / sigma_psi;
  return L;
}

Eigen::Matrix3d PoseGraph::LoopCommonCovariance(const Eigen::Vector3d& t_from_to) const {
  const double sigma = options_.loop_sigma_floor_m + options_.loop_sigma_per_m * t_from_to.norm();
  const Eigen::Vector3d along = options_.loop_scale_sigma * t_from_to;
  return sigma * sigma * Eigen::Matrix3d::Identity() + along * along.transpose();
}

Eigen::Matrix4d PoseGraph::LoopSqrtInformation(const PoseGraphLoop& loop) const {
  // psi's part of the rotation vector (frame `from`) is its component along gravity.
  const Eigen::Vector3d up =
      nodes_[static_cast<std::size_t>(loop.from)].T_W_B.q.conjugate() * Eigen::Vector3d::UnitZ();
  Eigen::Matrix<double, 4, 6> J = Eigen::Matrix<double, 4, 6>::Zero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.bottomRightCorner<1, 3>() = up.transpose();
  Eigen::Matrix4d covariance = J * loop.covariance * J.transpose();
  covariance.topLeftCorner<3, 3>() += LoopCommonCovariance(loop.T_from_to.t);
  covariance(3, 3) += std::pow(options_.loop_yaw_sigma_floor_deg * kDegree, 2);
  return SqrtInformation(covariance);
}

double PoseGraph::SquaredError(const PoseGraphLoop& loop) const {
  const PoseGraphNode& from = nodes_.at(static_cast<std::size_t>(loop.from));
  const PoseGraphNode& to = nodes_.at(static_cast<std::size_t>(loop.to));
  Eigen::Vector4d e;
  e.head<3>() = from.T_M_B().Inverse() * to.t_M_B - loop.T_from_to.t;
  e[3] = WrapAngle(to.psi - from.psi - DeltaPsi(from.T_W_B.q, loop.T_from_to.q, to.T_W_B.q));
  return (LoopSqrtInformation(loop) * e).squaredNorm();
}

void PoseGraph::TakeSolution(const PoseGraph& snapshot) {
  DEJA_VIEW_CHECK_OP(snapshot.size(), <=, size());
  // Sequences that were joined to others since stay where that has put them.
  const auto was_solved = [&](int sequence) {
    return sequence < static_cast<int>(snapshot.group_.size()) &&
           snapshot.Group(sequence) == Group(sequence);
  };
  for (int i = 0; i < size(); ++i) {
    PoseGraphNode& node = nodes_[static_cast<std::size_t>(i)];
    if (!was_solved(node.sequence)) {
      continue;
    }
    if (i < snapshot.size()) {
      node.psi = snapshot.nodes_[static_cast<std::size_t>(i)].psi;
      node.t_M_B = snapshot.nodes_[static_cast<std::size_t>(i)].t_M_B;
    } else if (i > 0 && nodes_[static_cast<std::size_t>(i - 1)].sequence == node.sequence) {
      node.psi = nodes_[static_cast<std::size_t>(i - 1)].psi;
      node.t_M_B = Correction(i - 1) * node.T_W_B.t;
    }
  }
  for (std::size_t i = 0; i < snapshot.loops_.size(); ++i) {
    loops_[i].weight = snapshot.loops_[i].weight;
  }
}

}  // namespace deja_view
