#include "navigate/global/pose_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "extperfc/base/math.hpp"

namespace extperfc::navigate {

namespace {

constexpr int kMaxExpanded = 15000;  // a passage that takes more is given up, for every kSpan_m of its path
constexpr double kSpan_m = 2.5;
constexpr double kPoseStep_m = 0.08;     // of the path, about
constexpr double kMaxWeight = 2;         // of cells: in a narrow passage all are dear
constexpr double kHolonomicGreed = 1.5;  // multiplies a holonomic base's estimate of the rest
constexpr double kBackwards = 2;         // times the cost of a step forwards
constexpr double kConnect_m = 0.5;       // a differential base drives straight to the end from here
constexpr double kConnect_rad = 0.35;
/// Directions of a differential base's steps [cells of the lattice].
constexpr std::array<std::array<int, 2>, 16> kDirections{{{{1, 0}},
                                                          {{2, 1}},
                                                          {{1, 1}},
                                                          {{1, 2}},
                                                          {{0, 1}},
                                                          {{-1, 2}},
                                                          {{-1, 1}},
                                                          {{-2, 1}},
                                                          {{-1, 0}},
                                                          {{-2, -1}},
                                                          {{-1, -1}},
                                                          {{-1, -2}},
                                                          {{0, -1}},
                                                          {{1, -2}},
                                                          {{1, -1}},
                                                          {{2, -1}}}};

double apart_rad(const Pose2& a, const Pose2& b) {
  return std::abs(wrap_angle(a.yaw - b.yaw));
}

}  // namespace

PoseSearch::PoseSearch(const CostGrid& costs, const Traversal& traversal, BaseKind base,
                       const PoseLattice& lattice, FootprintCheck check)
    : costs_(costs), traversal_(traversal), base_(base), lattice_(lattice), check_(std::move(check)) {
  if (base_ == BaseKind::kDifferential) {
    for (const auto& direction : kDirections) yaw_of_.push_back(std::atan2(direction[1], direction[0]));
    return;
  }
  for (int k = 0; k < lattice_.yaws; ++k)
    yaw_of_.push_back(wrap_angle(lattice_.anchor.yaw + kTwoPi * k / lattice_.yaws));
}

void PoseSearch::lay_out(const std::vector<Pose2>& along) {
  start_ = along.front();
  goal_ = along.back();
  const double step = lattice_.step_m;
  const int reach = static_cast<int>(std::ceil(lattice_.half_width_m / step));
  const auto place = [&](double value, double origin) {
    return static_cast<int>(std::lround((value - origin) / step));
  };
  if (base_ == BaseKind::kDifferential) frame_ = {start_.x, start_.y, lattice_.anchor.yaw};
  const Pose2 start = between(frame_, start_);
  const Pose2 anchor = between(frame_, lattice_.anchor);
  int left = 0;
  int right = 0;
  int bottom = 0;
  int top = 0;
  for (const Pose2& pose : along) {
    const Pose2 at = between(frame_, pose);
    left = std::min(left, place(at.x, start.x));
    right = std::max(right, place(at.x, start.x));
    bottom = std::min(bottom, place(at.y, start.y));
    top = std::max(top, place(at.y, start.y));
  }
  columns_ = right - left + 2 * reach + 1;
  rows_ = top - bottom + 2 * reach + 1;
  const double x_m = std::remainder(anchor.x - start.x, step);  // from the start to a place
  const double y_m = std::remainder(anchor.y - start.y, step);
  left_m_ = start.x + x_m + (left - reach) * step;
  bottom_m_ = start.y + y_m + (bottom - reach) * step;
  const auto places = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  nearest_.assign(places, -1);
  std::vector<int> squared(places, std::numeric_limits<int>::max());
  for (std::size_t i = 0; i < along.size(); ++i) {
    const Pose2 at_path = between(frame_, along[i]);
    const int column = place(at_path.x, left_m_);
    const int row = place(at_path.y, bottom_m_);
    for (int r = std::max(0, row - reach); r <= std::min(rows_ - 1, row + reach); ++r)
      for (int c = std::max(0, column - reach); c <= std::min(columns_ - 1, column + reach); ++c) {
        const int distance = (c - column) * (c - column) + (r - row) * (r - row);
        const auto at =
            static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(c);
        if (distance > reach * reach || distance >= squared[at]) continue;
        squared[at] = distance;
        nearest_[at] = static_cast<std::int16_t>(i);
      }
  }
  nodes_.assign(places * yaw_of_.size(), {std::numeric_limits<float>::infinity(), -1, false, -1});
}

Pose2 PoseSearch::pose_of(std::int32_t node) const {
  const int place = node / yaws();
  const int row = place / columns_;
  const int column = place - row * columns_;
  return compose(frame_, {left_m_ + column * lattice_.step_m, bottom_m_ + row * lattice_.step_m,
                          yaw_of_[static_cast<std::size_t>(node % yaws())]});
}

bool PoseSearch::is_free(std::int32_t node) {
  Node& state = nodes_[static_cast<std::size_t>(node)];
  if (state.free < 0) state.free = check_.is_free(pose_of(node)) ? 1 : 0;
  return state.free == 1;
}

float PoseSearch::rest_of(const Pose2& pose) const {
  const double greed = base_ == BaseKind::kHolonomic ? kHolonomicGreed : 1.0;
  return static_cast<float>(greed *
                            (distance_m(pose, goal_) + kRotationPrice_m_per_rad * apart_rad(pose, goal_)));
}

bool PoseSearch::reaches_goal(const Pose2& pose) const {
  const double distance_m = extperfc::distance_m(pose, goal_);
  if (base_ == BaseKind::kHolonomic)
    return distance_m < 1.5 * lattice_.step_m && apart_rad(pose, goal_) < 1.5 * kTwoPi / yaws() &&
           check_.is_free_along(pose, goal_);
  if (distance_m > kConnect_m) return false;
  const double yaw = distance_m > 1e-9 ? std::atan2(goal_.y - pose.y, goal_.x - pose.x) : pose.yaw;
  const Pose2 headed{pose.x, pose.y, yaw};
  const Pose2 arrived{goal_.x, goal_.y, yaw};
  return (distance_m < 1.5 * lattice_.step_m || apart_rad(pose, headed) < kConnect_rad) &&
         check_.is_free_along(pose, headed) && check_.is_free_along(headed, arrived) &&
         check_.is_free_along(arrived, goal_);
}

std::vector<PoseSearch::Move> PoseSearch::moves_from(int yaw) const {
  if (base_ == BaseKind::kDifferential) {
    const auto& ahead = kDirections[static_cast<std::size_t>(yaw)];
    return {{ahead[0], ahead[1], 0}, {-ahead[0], -ahead[1], 0}, {0, 0, 1}, {0, 0, -1}};
  }
  return {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},   {0, -1, 0}, {1, 1, 0},
          {-1, 1, 0}, {1, -1, 0}, {-1, -1, 0}, {0, 0, 1},  {0, 0, -1}};
}

void PoseSearch::begin() {
  open_ = {};
  reached_ = -1;
  progress_ = 0;
  const Pose2 start = between(frame_, start_);
  const int left = static_cast<int>(std::floor((start.x - left_m_) / lattice_.step_m));
  const int low = static_cast<int>(std::floor((start.y - bottom_m_) / lattice_.step_m));
  const double spacing = base_ == BaseKind::kHolonomic ? kTwoPi / yaws() : 0.5;
  for (int yaw = 0; yaw < yaws(); ++yaw)
    for (int corner = 0; corner < 4; ++corner) {
      const std::int32_t node = index(left + corner % 2, low + corner / 2, yaw);
      const Pose2 pose = pose_of(node);
      const double distance_m = extperfc::distance_m(pose, start_);
      // A differential base begins exactly at the start: its lattice is anchored there.
      if (base_ == BaseKind::kDifferential && distance_m > 1e-6) continue;
      if (apart_rad(pose, start_) > 1.01 * spacing || !check_.is_free_along(start_, pose)) continue;
      Node& state = nodes_[static_cast<std::size_t>(node)];
      state.path_cost = static_cast<float>(distance_m + kRotationPrice_m_per_rad * apart_rad(pose, start_));
      open_.emplace(state.path_cost + rest_of(pose), node);
    }
}

/// Of two free poses: at steps of half a cell of any corner's motion.
bool PoseSearch::is_free_between(const Pose2& from, const Pose2& to) const {
  const double yaw = wrap_angle(to.yaw - from.yaw);
  const double motion_m = distance_m(from, to) + std::abs(yaw) * check_.radius_m;
  const double steps = std::ceil(motion_m / (0.5 * costs_.resolution_m) - 1e-6);
  for (double k = 1; k < steps; ++k) {
    const double part = k / steps;
    if (!check_.is_free(
            {from.x + part * (to.x - from.x), from.y + part * (to.y - from.y), from.yaw + part * yaw}))
      return false;
  }
  return true;
}

void PoseSearch::offer(std::int32_t from, std::int32_t to, const Move& move) {
  Node& state = nodes_[static_cast<std::size_t>(to)];
  if (state.settled || state.free == 0) return;
  const Pose2 here = pose_of(from);
  const Pose2 next = pose_of(to);
  double cost = kRotationPrice_m_per_rad * apart_rad(here, next);
  if (move.yaw_steps == 0) {
    const auto cell = costs_.cell_of({next.x, next.y});
    const auto weight = static_cast<double>(cell ? traversal_.weight[costs_.at(*cell)] : 0.0F);
    cost = distance_m(here, next) * (weight > 0 ? std::min(weight, kMaxWeight) : kMaxWeight);
    const Eigen::Vector2d ahead(std::cos(here.yaw), std::sin(here.yaw));
    const bool forwards = ahead.x() * (next.x - here.x) + ahead.y() * (next.y - here.y) > 0;
    if (base_ == BaseKind::kDifferential && forwards == lattice_.backwards) cost *= kBackwards;
  }
  const float reached = nodes_[static_cast<std::size_t>(from)].path_cost + static_cast<float>(cost);
  if (!(reached < state.path_cost) || !is_free(to) || !is_free_between(here, next)) return;
  state.path_cost = reached;
  state.parent = from;
  open_.emplace(reached + rest_of(next), to);
}

void PoseSearch::expand(std::int32_t node) {
  const int yaw = node % yaws();
  const int place = node / yaws();
  for (const Move& move : moves_from(yaw)) {
    const int column = place % columns_ + move.columns;
    const int row = place / columns_ + move.rows;
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) continue;
    if (nearest_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                 static_cast<std::size_t>(column)] < 0)
      continue;
    offer(node, index(column, row, (yaw + move.yaw_steps + yaws()) % yaws()), move);
  }
}

PoseSearch::Status PoseSearch::find(const std::vector<Pose2>& along, const PlanClock& clock) {
  const double spans = std::max(1.0, kPoseStep_m * static_cast<double>(along.size()) / kSpan_m);
  lay_out(along);
  begin();
  const int limit = static_cast<int>(kMaxExpanded * spans);
  for (int expanded = 1; !open_.empty() && expanded < limit; ++expanded) {
    const std::int32_t node = open_.top().second;
    open_.pop();
    Node& state = nodes_[static_cast<std::size_t>(node)];
    if (state.settled) continue;
    state.settled = true;
    progress_ = std::max(progress_, static_cast<std::size_t>(
                                        std::max<int>(0, nearest_[static_cast<std::size_t>(node / yaws())])));
    if (reaches_goal(pose_of(node))) {
      reached_ = node;
      return Status::kFound;
    }
    expand(node);
    if (expanded % 128 == 0 && clock.ended()) return Status::kInterrupted;
  }
  return Status::kNoPath;
}

std::vector<Pose2> PoseSearch::poses() const {
  std::vector<Pose2> out{goal_};
  const Pose2 last = pose_of(reached_);
  if (base_ == BaseKind::kDifferential && distance_m(last, goal_) > 1e-9) {
    const double yaw = std::atan2(goal_.y - last.y, goal_.x - last.x);
    out.push_back({goal_.x, goal_.y, yaw});
    out.push_back({last.x, last.y, yaw});
  }
  for (std::int32_t node = reached_; node >= 0; node = nodes_[static_cast<std::size_t>(node)].parent)
    out.push_back(pose_of(node));
  out.push_back(start_);
  std::reverse(out.begin(), out.end());
  return out;
}

}  // namespace extperfc::navigate
