#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/velocity.hpp"
#include "extperfc/world/pose.hpp"

#include "navigate/global/plan_clock.hpp"
#include "navigate/global/traversal.hpp"

namespace extperfc::navigate {

inline constexpr double kRotationPrice_m_per_rad = 0.3;  ///< what a rotation adds to the length of a path

/// The lattice of a PoseSearch.
struct PoseLattice {
  double half_width_m{0.4};  ///< of the corridor around the path
  double step_m{0.05};
  int yaws{48};    ///< of a circle; a differential base has 16 directions of steps instead
  Pose2 anchor{};  ///< one of its poses; a differential base: its first pose, and the lattice's direction
  bool backwards{false};  ///< the path will be driven from its last pose to its first one
};

/// What a search asks about the footprint.
struct FootprintCheck {
  std::function<bool(const Pose2&)> is_free;
  std::function<bool(const Pose2&, const Pose2&)> is_free_along;
  double radius_m;  ///< of the footprint's circumscribed circle
};

/// A* over x, y and yaw in a corridor around a part of a path, from its first to its last pose. Costs:
/// metres times the cells' weight, and 0.3 m per radian.
class PoseSearch {
 public:
  PoseSearch(const CostGrid& costs, const Traversal& traversal, BaseKind base, const PoseLattice& lattice,
             FootprintCheck check);

  enum class Status { kFound, kNoPath, kInterrupted };
  /// Precondition: at least two poses.
  Status find(const std::vector<Pose2>& along, const PlanClock& clock);
  /// kFound: from the first to the last pose, motions between neighbours are free.
  [[nodiscard]] std::vector<Pose2> poses() const;
  /// kNoPath: the pose of the path up to which the search came.
  [[nodiscard]] std::size_t progress() const { return progress_; }

 private:
  struct Node {
    float path_cost;
    std::int32_t parent;
    bool settled;
    std::int8_t free;  ///< -1: not asked yet
  };
  struct Move {
    int columns;
    int rows;
    int yaw_steps;
  };
  using Entry = std::pair<float, std::int32_t>;

  void lay_out(const std::vector<Pose2>& along);
  [[nodiscard]] std::vector<Move> moves_from(int yaw) const;
  [[nodiscard]] int yaws() const { return static_cast<int>(yaw_of_.size()); }
  [[nodiscard]] std::int32_t index(int column, int row, int yaw) const {
    return (row * columns_ + column) * yaws() + yaw;
  }
  [[nodiscard]] Pose2 pose_of(std::int32_t node) const;
  [[nodiscard]] bool is_free(std::int32_t node);
  [[nodiscard]] float rest_of(const Pose2& pose) const;
  [[nodiscard]] bool reaches_goal(const Pose2& pose) const;
  [[nodiscard]] bool is_free_between(const Pose2& from, const Pose2& to) const;
  void begin();
  void expand(std::int32_t node);
  void offer(std::int32_t from, std::int32_t to, const Move& move);

  const CostGrid& costs_;
  const Traversal& traversal_;
  BaseKind base_;
  PoseLattice lattice_;
  FootprintCheck check_;
  Pose2 start_;
  Pose2 goal_;
  Pose2 frame_;  ///< of the lattice
  double left_m_{0};
  double bottom_m_{0};
  int columns_{0};
  int rows_{0};
  std::vector<double> yaw_of_;
  std::vector<std::int16_t> nearest_;  ///< pose of the path, of each place; -1: outside the corridor
  std::vector<Node> nodes_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
  std::int32_t reached_{-1};
  std::size_t progress_{0};
};

}  // namespace extperfc::navigate
