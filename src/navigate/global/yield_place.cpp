#include "extperfc/navigate/yield_place.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "extperfc/base/math.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kCoarseM = 0.1;       // step of the search, at least a cell
constexpr double kPersonM = 0.4;       // a person's radius, and what the robot keeps clear of it
constexpr double kBeyondM = 3.0;       // beyond the farthest place, what the person may want to reach counts
constexpr double kEnoughLeft = 0.7;    // of what is behind the robot the person should still reach,
constexpr double kBranchLeft = 0.5;    // and so much of each branch of what is behind the place
constexpr double kMinLeft = 0.5;       // without such a place: the least of what is behind the robot
constexpr double kSmallBranch = 0.05;  // of all that can be reached: does not count
constexpr int kYawChoices = 8;

/// What the base's middle reaches from a start, without passing a person.
class ReachableCells {
 public:
  ReachableCells(const CostGrid& costs, const Pose2& start, const Eigen::Vector2d& person_m,
                 double person_radius_m)
      : costs_(costs),
        stride_(std::max(1, static_cast<int>(std::lround(kCoarseM / costs.resolution_m)))),
        start_m_(start.x, start.y) {
    const int cells = static_cast<int>(std::ceil((kYieldReachM + kBeyondM) / (stride_ * costs.resolution_m)));
    side_ = 2 * cells + 1;
    nodes_.resize(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
    search(person_m, person_radius_m);
  }

  /// Metres along the path; infinity where none leads.
  [[nodiscard]] double length_m(int node) const { return nodes_[static_cast<std::size_t>(node)].length_m; }
  [[nodiscard]] Eigen::Vector2d middle_m(int node) const {
    const int half = side_ / 2;
    return start_m_ +
           stride_ * costs_.resolution_m * Eigen::Vector2d(node % side_ - half, node / side_ - half);
  }
  /// Every second column and row of what was reached, the nearest first.
  [[nodiscard]] std::vector<int> by_length() const {
    std::vector<int> nodes;
    for (const int node : reached_)
      if (node % side_ % 2 == 0 && node / side_ % 2 == 0) nodes.push_back(node);
    return nodes;
  }
  /// Marks what a person can still reach from the start who keeps a distance from a place.
  void walk_past(const Eigen::Vector2d& place_m, double distance_m) {
    ++visit_;
    ++walks_;
    const auto may_walk = [&](int node) {
      return reached(node) && (middle_m(node) - place_m).norm() >= distance_m;
    };
    flood(start_node(), may_walk, [&](int node) { nodes_[static_cast<std::size_t>(node)].walked = walks_; });
  }
  /// Of what is farther than a length: the part that is marked.
  [[nodiscard]] double part_left(double beyond_m) const {
    std::size_t all = 0;
    std::size_t left = 0;
    for (auto node = reached_.rbegin(); node != reached_.rend() && length_m(*node) > beyond_m; ++node) {
      ++all;
      left += walked(*node);
    }
    return all > 0 ? static_cast<double>(left) / static_cast<double>(all) : 0;
  }
  /// The same of the branch of it that has least left; small ones do not count.
  [[nodiscard]] double min_branch_left(double beyond_m) {
    ++visit_;
    double min_left = 1;
    const auto is_beyond = [&](int node) { return reached(node) && length_m(node) > beyond_m; };
    for (auto first = reached_.rbegin(); first != reached_.rend() && length_m(*first) > beyond_m; ++first) {
      if (nodes_[static_cast<std::size_t>(*first)].visit == visit_) continue;
      std::size_t all = 0;
      std::size_t left = 0;
      flood(*first, is_beyond, [&](int node) {
        ++all;
        left += walked(node);
      });
      if (static_cast<double>(all) >= kSmallBranch * static_cast<double>(reached_.size()))
        min_left = std::min(min_left, static_cast<double>(left) / static_cast<double>(all));
    }
    return min_left;
  }

 private:
  struct Node {
    double length_m{std::numeric_limits<double>::infinity()};
    int visit{0};   ///< of flood()
    int walked{0};  ///< of walk_past()
  };

  [[nodiscard]] bool reached(int node) const { return std::isfinite(length_m(node)); }
  [[nodiscard]] bool walked(int node) const {
    return nodes_[static_cast<std::size_t>(node)].walked == walks_;
  }
  /// Visits what is connected to a node, which is visited in any case.
  template <class May, class Visit>
  void flood(int first, const May& may, const Visit& visit) {
    std::vector<int> open{first};
    nodes_[static_cast<std::size_t>(first)].visit = visit_;
    while (!open.empty()) {
      const int here = open.back();
      open.pop_back();
      visit(here);
      for_each_neighbour(here, [&](int next, double) {
        int& last = nodes_[static_cast<std::size_t>(next)].visit;
        if (last == visit_ || !may(next)) return;
        last = visit_;
        open.push_back(next);
      });
    }
  }

  [[nodiscard]] int start_node() const { return (side_ / 2) * side_ + side_ / 2; }
  template <class Visit>
  void for_each_neighbour(int node, const Visit& visit) const {
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int column = node % side_ + dx;
        const int row = node / side_ + dy;
        if ((dx == 0 && dy == 0) || column < 0 || row < 0 || column >= side_ || row >= side_) continue;
        visit(row * side_ + column, std::hypot(dx, dy) * stride_ * costs_.resolution_m);
      }
  }

  [[nodiscard]] bool may_be_at(const Eigen::Vector2d& at_m) const {
    const auto cell = costs_.cell_of(at_m);
    return cell && costs_.at(*cell) < kInscribedCost;
  }

  void search(const Eigen::Vector2d& person_m, double person_radius_m) {
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    nodes_[static_cast<std::size_t>(start_node())].length_m = 0;
    open.emplace(0, start_node());
    while (!open.empty()) {
      const auto [length_m, node] = open.top();
      open.pop();
      if (length_m > this->length_m(node)) continue;
      reached_.push_back(node);
      for_each_neighbour(node, [&, from_m = length_m, at = node](int next, double step_m) {
        double& there_m = nodes_[static_cast<std::size_t>(next)].length_m;
        const double next_m = from_m + step_m;
        if (next_m >= there_m || next_m > kYieldReachM + kBeyondM || !may_be_at(middle_m(next))) return;
        // Near the person a step away from them does not pass them.
        const double away_m = (middle_m(next) - person_m).norm();
        if (away_m < person_radius_m && away_m < (middle_m(at) - person_m).norm()) return;
        there_m = next_m;
        open.emplace(next_m, next);
      });
    }
  }

  const CostGrid& costs_;
  int stride_;
  Eigen::Vector2d start_m_;
  int side_{0};
  std::vector<Node> nodes_;
  std::vector<int> reached_;  ///< nearest first
  int visit_{0};
  int walks_{0};
};

/// From a point to a straight line between two.
double distance_to_line_m(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m,
                          const Eigen::Vector2d& at_m) {
  const Eigen::Vector2d line = to_m - from_m;
  const double along = std::clamp(line.dot(at_m - from_m) / std::max(1e-9, line.squaredNorm()), 0.0, 1.0);
  return (from_m + along * line - at_m).norm();
}

/// The yaw nearest to the start's at which the footprint is free.
std::optional<Pose2> free_pose_at(const CostGrid& costs, const Footprint& footprint,
                                  const Eigen::Vector2d& at_m, double yaw) {
  for (int i = 0; i < kYawChoices; ++i) {
    const int rotation = (i + 1) / 2 * (i % 2 == 0 ? 1 : -1);
    const Pose2 pose{at_m.x(), at_m.y(), wrap_angle(yaw + rotation * kTwoPi / kYawChoices)};
    if (contact(costs, footprint, pose) == Contact::kFree) return pose;
  }
  return std::nullopt;
}

struct Place {
  Pose2 pose;
  bool enough{false};  ///< is left of all that the person may want to reach
};

/// The nearest one with enough left, else the one with most left.
std::optional<Place> place_beside(ReachableCells& reach, const CostGrid& costs, const Footprint& footprint,
                                  const Pose2& start, const Eigen::Vector2d& person_m, double distance_m) {
  const Eigen::Vector2d start_m(start.x, start.y);
  std::optional<Place> best;
  double max_left = kMinLeft;
  for (const int node : reach.by_length()) {
    if (reach.length_m(node) > kYieldReachM) break;
    const Eigen::Vector2d at_m = reach.middle_m(node);
    if (distance_to_line_m(person_m, start_m, at_m) < distance_m) continue;
    reach.walk_past(at_m, distance_m);
    const double left = reach.part_left(reach.length_m(node) / 2);
    const bool enough = left >= kEnoughLeft && reach.min_branch_left(reach.length_m(node)) >= kBranchLeft;
    if (left <= max_left && !enough) continue;
    const auto pose = free_pose_at(costs, footprint, at_m, start.yaw);
    if (!pose) continue;
    best = Place{*pose, enough};
    max_left = left;
    if (enough) break;
  }
  return best;
}

}  // namespace

std::optional<Pose2> yield_place(const CostGrid& costs, const Footprint& footprint, const Pose2& start,
                                 const Eigen::Vector2d& person_m) {
  if (!is_finite(start) || !person_m.allFinite() || !costs.cell_of({start.x, start.y})) return std::nullopt;
  ReachableCells reach(costs, start, person_m, kPersonM + footprint.inscribed_radius_m());
  std::optional<Place> place;
  for (const double distance_m : {kRoomyYieldM, kYieldM}) {
    place = place_beside(reach, costs, footprint, start, person_m, distance_m);
    if (place && place->enough) break;
  }
  if (!place) return std::nullopt;
  return place->pose;
}

}  // namespace extperfc::navigate
