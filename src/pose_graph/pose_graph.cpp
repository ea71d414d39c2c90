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

void Erase(int value, std::vector<int>* list) {
  const auto it = std::find(list->begin(), list->end(), value);
  if (it != list->end()) {
    list->erase(it);
  }
}

void Insert(int value, std::vector<int>* list) {
  if (std::find(list->begin(), list->end(), value) == list->end()) {
    list->push_back(value);
  }
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
  r.That(window >= 0, "window must not be negative");
  r.That(withdraw_weight >= 0 && withdraw_weight < 1, "withdraw_weight must be in [0, 1)");
  r.That(withdraw_after > 0, "withdraw_after must be positive");
  return r.errors();
}

PoseGraph PoseGraph::FromParts(const PoseGraphOptions& options,
                               const std::vector<Part>& parts,
                               const std::vector<PoseGraphLoop>& loops) {
  PoseGraph graph(options);
  for (const Part& part : parts) {
    const int id = graph.AddNode(part.node.sequence, part.node.T_W_B, part.node.is_fixed);
    graph.Live(id).node = part.node;
    if (part.is_kept) {
      graph.Keep(id);
    }
  }
  for (const PoseGraphLoop& loop : loops) {
    DEJA_VIEW_CHECK(loop.from >= 0 && loop.from < graph.size());
    DEJA_VIEW_CHECK(loop.to >= 0 && loop.to < graph.size());
    const int a = graph.Group(graph.Record(loop.from).sequence);
    const int b = graph.Group(graph.Record(loop.to).sequence);
    std::replace(graph.group_.begin(), graph.group_.end(), std::max(a, b), std::min(a, b));
    if (!graph.Record(loop.from).is_fixed || !graph.Record(loop.to).is_fixed) {
      graph.AddLoop(loop);
    }
  }
  graph.map_group_ = graph.group_;
  // What never moves is no node that could be of use, unless it can be seen again.
  const std::vector<int> live = graph.live_;
  int holder = -1;
  for (const int id : live) {
    if (graph.Live(id).is_kept) {
      holder = id;
    } else if (graph.Record(id).is_fixed) {
      graph.window_.erase(std::find(graph.window_.begin(), graph.window_.end(), id));
      graph.Hang(id, {holder});
    }
  }
  return graph;
}

int PoseGraph::TakeSlot() {
  if (free_slots_.empty()) {
    slots_.emplace_back();
    return static_cast<int>(slots_.size()) - 1;
  }
  const int slot = free_slots_.back();
  free_slots_.pop_back();
  return slot;
}

int PoseGraph::AddNode(int sequence, const Rigid3& T_W_B, bool is_fixed) {
  DEJA_VIEW_CHECK_OP(sequence, >=, 0);
  const int id = size();
  const bool is_first = id == 0 || keyframes_.back().sequence != sequence;
  Keyframe keyframe;
  keyframe.q_W_B = T_W_B.q.coeffs();
  keyframe.t_W_B = T_W_B.t;
  keyframe.sequence = sequence;
  keyframe.is_fixed = is_fixed;
  Slot slot;
  slot.node = {sequence, is_fixed, T_W_B, 0.0, T_W_B.t};
  slot.is_kept = is_first;
  if (!is_first) {
    slot.node.psi = node(id - 1).psi;
    slot.node.t_M_B = Correction(id - 1) * T_W_B.t;
    keyframe.path = keyframes_.back().path + (T_W_B.t - keyframes_.back().t_W_B).norm();
  }
  while (static_cast<int>(group_.size()) <= sequence) {
    group_.push_back(static_cast<int>(group_.size()));
    first_.push_back(id);
  }
  keyframe.slot = TakeSlot();
  keyframes_.push_back(keyframe);
  live_.push_back(id);
  if (!is_first) {
    window_.push_back(id);
  }
  slots_[static_cast<std::size_t>(keyframe.slot)] = std::move(slot);
  if (!is_first) {
    AddOdometry(id - 1, id, (T_W_B.t - Record(id - 1).t_W_B).norm());
  }
  return id;
}

void PoseGraph::Keep(int node) {
  DEJA_VIEW_CHECK(IsLive(node));
  Live(node).is_kept = true;
  const auto it = std::find(window_.rbegin(), window_.rend(), node);
  if (it != window_.rend()) {
    window_.erase(std::next(it).base());
  }
}

PoseGraphNode PoseGraph::node(int i) const {
  const Keyframe& k = Record(i);
  if (k.slot >= 0) {
    return Live(i).node;
  }
  PoseGraphNode node = {
      k.sequence, k.is_fixed, {Eigen::Quaterniond(k.q_W_B), k.t_W_B}, 0.0, Eigen::Vector3d::Zero()};
  const auto place = [&](const Hook& hook) {
    const PoseGraphNode& holder = Live(hook.holder).node;
    node.psi = WrapAngle(holder.psi + hook.psi);
    node.t_M_B = holder.t_M_B + FromYaw(holder.psi) * hook.t;
  };
  place(k.hooks[0]);
  if (k.hooks[1].holder >= 0) {
    const PoseGraphNode first = node;
    const auto share = static_cast<double>(k.share);
    place(k.hooks[1]);
    node.psi = WrapAngle(first.psi + share * WrapAngle(node.psi - first.psi));
    node.t_M_B = (1.0 - share) * first.t_M_B + share * node.t_M_B;
  }
  return node;
}

Rigid3 PoseGraph::Correction(int node) const {
  const PoseGraphNode n = this->node(node);
  const Eigen::Quaterniond q = FromYaw(n.psi);
  return {q, n.t_M_B - q * n.T_W_B.t};
}

int PoseGraph::Group(int sequence) const {
  return group_.at(static_cast<std::size_t>(sequence));
}

bool PoseGraph::AreJoinedInMap(int a, int b) const {
  const auto group = [&](int sequence) {
    const auto s = static_cast<std::size_t>(sequence);
    return s < map_group_.size() ? map_group_[s] : sequence;
  };
  return group(a) == group(b);
}

bool PoseGraph::IsAnchored(int sequence) const {
  return !keyframes_.empty() && Group(sequence) == Group(keyframes_.front().sequence);
}

double PoseGraph::PathLength(int from, int to) const {
  return std::abs(Record(to).path - Record(from).path);
}

PoseGraphLoop PoseGraph::WithLiveEnds(PoseGraphLoop loop) const {
  if (!IsLive(loop.to)) {
    const int holder = Record(loop.to).hooks[0].holder;
    loop.T_from_to = loop.T_from_to * (node(loop.to).T_M_B().Inverse() * node(holder).T_M_B());
    loop.to = holder;
  }
  if (!IsLive(loop.from)) {
    const int holder = Record(loop.from).hooks[0].holder;
    loop.T_from_to = node(holder).T_M_B().Inverse() * node(loop.from).T_M_B() * loop.T_from_to;
    loop.from = holder;
  }
  return loop;
}

int PoseGraph::AddLoop(const PoseGraphLoop& loop) {
  DEJA_VIEW_CHECK(loop.from >= 0 && loop.from < size());
  DEJA_VIEW_CHECK(loop.to >= 0 && loop.to < size());
  if (Group(Record(loop.from).sequence) != Group(Record(loop.to).sequence)) {
    JoinGroups(loop);
  }
  const int id = next_loop_++;
  const PoseGraphLoop added = WithLiveEnds(loop);
  if (added.from != added.to) {
    loops_.emplace_hint(loops_.end(), id, added);
    Live(added.from).loops.push_back(id);
    Live(added.to).loops.push_back(id);
  }
  return id;
}

void PoseGraph::UpdateLoop(int id, const Rigid3& T_from_to) {
  loops_.at(id).T_from_to = T_from_to;
}

void PoseGraph::RemoveLoop(int id) {
  const PoseGraphLoop& loop = loops_.at(id);
  Erase(id, &Live(loop.from).loops);
  Erase(id, &Live(loop.to).loops);
  loops_.erase(id);
}

void PoseGraph::JoinGroups(const PoseGraphLoop& loop) {
  const PoseGraphNode from = node(loop.from);
  const PoseGraphNode to = node(loop.to);
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
  MoveGroup(moved, yaw, T_M_end.t - q * end.t_M_B);
  std::replace(group_.begin(), group_.end(), moved, kept);
}

void PoseGraph::MoveGroup(int group, double yaw, const Eigen::Vector3d& t) {
  const Eigen::Quaterniond q = FromYaw(yaw);
  for (const int id : live_) {
    PoseGraphNode& node = Live(id).node;
    if (Group(node.sequence) == group) {
      node.psi = WrapAngle(node.psi + yaw);
      node.t_M_B = q * node.t_M_B + t;
    }
  }
}

Eigen::Matrix4d PoseGraph::OdometryInformation(double distance) const {
  const double root = std::sqrt(distance);
  const double sigma_t =
      std::hypot(options_.odometry_sigma_floor_m, options_.odometry_sigma_per_sqrt_m * root);
  const double sigma_psi = kDegree * std::hypot(options_.odometry_yaw_sigma_floor_deg,
                                                options_.odometry_yaw_sigma_per_sqrt_m_deg * root);
  const Eigen::Vector4d L(1 / sigma_t, 1 / sigma_t, 1 / sigma_t, 1 / sigma_psi);
  return L.cwiseAbs2().asDiagonal();
}

void PoseGraph::AddOdometry(int from, int to, double distance) {
  const PoseGraphNode& i = Live(from).node;
  const PoseGraphNode& j = Live(to).node;
  if (i.is_fixed && j.is_fixed) {
    return;
  }
  PoseGraphTie tie;
  tie.from = from;
  tie.to = to;
  tie.t_I_J = i.T_W_B.q.conjugate() * (j.T_W_B.t - i.T_W_B.t);
  tie.information = OdometryInformation(distance);
  AddTie(tie);
}

void PoseGraph::AddTie(const PoseGraphTie& tie) {
  DEJA_VIEW_CHECK_OP(tie.from, <, tie.to);
  const auto [it, is_new] = ties_.try_emplace({tie.from, tie.to}, tie);
  if (is_new) {
    Insert(tie.to, &Live(tie.from).neighbours);
    Insert(tie.from, &Live(tie.to).neighbours);
    return;
  }
  // Two measurements of one thing: their errors are linear in what is measured.
  PoseGraphTie& known = it->second;
  Eigen::Vector4d difference;
  difference << tie.t_I_J - known.t_I_J, WrapAngle(tie.delta_psi - known.delta_psi);
  known.information += tie.information;
  const Eigen::Vector4d step = known.information.ldlt().solve(tie.information * difference);
  known.t_I_J += step.head<3>();
  known.delta_psi = WrapAngle(known.delta_psi + step[3]);
}

void PoseGraph::RemoveTie(int a, int b) {
  ties_.erase({std::min(a, b), std::max(a, b)});
  Erase(a, &Live(b).neighbours);
  Erase(b, &Live(a).neighbours);
}

Eigen::Matrix3d PoseGraph::LoopCommonCovariance(const Eigen::Vector3d& t_from_to) const {
  const double sigma = options_.loop_sigma_floor_m + options_.loop_sigma_per_m * t_from_to.norm();
  const Eigen::Vector3d along = options_.loop_scale_sigma * t_from_to;
  return sigma * sigma * Eigen::Matrix3d::Identity() + along * along.transpose();
}

Eigen::Matrix4d PoseGraph::LoopSqrtInformation(const PoseGraphLoop& loop) const {
  // psi's part of the rotation vector (frame `from`) is its component along gravity.
  const Eigen::Vector3d up =
      Eigen::Quaterniond(Record(loop.from).q_W_B).conjugate() * Eigen::Vector3d::UnitZ();
  Eigen::Matrix<double, 4, 6> J = Eigen::Matrix<double, 4, 6>::Zero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.bottomRightCorner<1, 3>() = up.transpose();
  Eigen::Matrix4d covariance = J * loop.covariance * J.transpose();
  covariance.topLeftCorner<3, 3>() += LoopCommonCovariance(loop.T_from_to.t);
  covariance(3, 3) += std::pow(options_.loop_yaw_sigma_floor_deg * kDegree, 2);
  return SqrtInformation(covariance);
}

double PoseGraph::SquaredError(const PoseGraphLoop& loop) const {
  const PoseGraphNode from = node(loop.from);
  const PoseGraphNode to = node(loop.to);
  Eigen::Vector4d e;
  e.head<3>() = from.T_M_B().Inverse() * to.t_M_B - loop.T_from_to.t;
  e[3] = WrapAngle(to.psi - from.psi - DeltaPsi(from.T_W_B.q, loop.T_from_to.q, to.T_W_B.q));
  return (LoopSqrtInformation(loop) * e).squaredNorm();
}

}  // namespace deja_view
