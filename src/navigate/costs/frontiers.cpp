#include "extperfc/navigate/frontiers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <utility>

#include "extperfc/base/math.hpp"
#include "extperfc/navigate/inflation_layer.hpp"

#include "navigate/costs/polygon.hpp"

namespace extperfc::navigate {

namespace {

using Eigen::Vector2d;

constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr float kDiagonal = 1.41421356F;

/// The cells around one; those along the sides first.
constexpr std::array<Cell, 8> kNeighbours{
    {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
constexpr std::size_t kSides = 4;

/// Cells where the base may be as far as its inscribed radius is concerned: 1, else 0.
std::vector<std::uint8_t> open_cells(const CostGrid& costs, double inscribed_radius_m,
                                     bool unknown_is_lethal) {
  CostGrid grid = costs;
  if (unknown_is_lethal) std::replace(grid.cells.begin(), grid.cells.end(), kUnknownCost, kLethalCost);
  InflationLayer layer({inscribed_radius_m, inscribed_radius_m, 0});
  layer.match(grid);
  layer.write(grid, grid.box());
  std::vector<std::uint8_t> open(grid.cells.size());
  std::transform(grid.cells.begin(), grid.cells.end(), open.begin(),
                 [](Cost cost) { return static_cast<std::uint8_t>(cost < kInscribedCost ? 1 : 0); });
  return open;
}

class FrontierSearch {
 public:
  FrontierSearch(const CostGrid& costs, const Footprint& footprint, const FrontierQuery& query,
                 const FrontierParams& params)
      : costs_(costs),
        footprint_(footprint),
        query_(query),
        params_(params),
        radius_m_(std::max(0.0, footprint.inscribed_radius_m() - params.passage_slack_m)),
        visits_(costs.cells.size(), 0) {}

  [[nodiscard]] NavResult<FrontierList> run() {
    const auto known_open = open_cells(costs_, radius_m_, false);
    const auto drivable = params_.allow_unknown ? known_open : open_cells(costs_, radius_m_, true);
    const auto start = nearest_open(drivable);
    if (!start)
      return nav_fail(
          NavCode::kStartBlocked,
          "exploration: no free cell near the robot's pose; move the robot, or check its localization",
          query_.start);
    find_paths(drivable, *start);
    const double wide_m = std::max(0.0, footprint_.inscribed_radius_m() - 0.5 * params_.passage_slack_m);
    find_frontier_cells(known_open, open_cells(costs_, wide_m, false), *start);
    FrontierList list;
    for (const std::size_t index : frontier_cells_)
      if (belongs_[index] == kFree) add(take_cluster(index), list);
    std::stable_sort(list.frontiers.begin(), list.frontiers.end(),
                     [](const Frontier& a, const Frontier& b) { return a.score > b.score; });
    return list;
  }

 private:
  enum Belongs : std::uint8_t { kNone, kFree, kTaken };  ///< to no frontier, to one, to one of a cluster

  [[nodiscard]] Cell cell_at(std::size_t index) const {
    const auto width = static_cast<std::size_t>(costs_.width);
    return {static_cast<int>(index % width), static_cast<int>(index / width)};
  }

  /// Calls `visit(cell, index)` for the neighbours inside the grid.
  template <typename Visit>
  void visit_neighbours(std::size_t index, std::size_t count, const Visit& visit) const {
    const Cell cell = cell_at(index);
    for (std::size_t i = 0; i < count; ++i) {
      const Cell next{cell.column + kNeighbours[i].column, cell.row + kNeighbours[i].row};
      if (costs_.contains(next)) visit(costs_.index(next), i);
    }
  }

  /// Breadth first from a cell over cells for which `passes(index)`, at most `max_m` away, until
  /// `found(index)`.
  template <typename Passes, typename Found>
  std::optional<std::size_t> search(std::size_t from, double max_m, const Passes& passes,
                                    const Found& found) {
    ++visit_;
    const Vector2d begin_m = costs_.middle_of(cell_at(from));
    std::vector<std::size_t> queue{from};
    visits_[from] = visit_;
    for (std::size_t i = 0; i < queue.size(); ++i) {
      if (found(queue[i])) return queue[i];
      visit_neighbours(queue[i], kNeighbours.size(), [&](std::size_t next, std::size_t) {
        if (visits_[next] == visit_ || !passes(next)) return;
        if ((costs_.middle_of(cell_at(next)) - begin_m).norm() > max_m) return;
        visits_[next] = visit_;
        queue.push_back(next);
      });
    }
    return std::nullopt;
  }

  /// Never through lethal cells.
  [[nodiscard]] std::optional<std::size_t> nearest_open(const std::vector<std::uint8_t>& open) {
    const auto start = costs_.index(costs_.cell_around({query_.start.x, query_.start.y}));
    return search(
        start, params_.start_tolerance_m, [&](std::size_t i) { return costs_.cells[i] != kLethalCost; },
        [&](std::size_t i) { return open[i] != 0; });
  }

  /// Dijkstra's distances over eight neighbours [cells].
  void find_paths(const std::vector<std::uint8_t>& open, std::size_t start) {
    using Entry = std::pair<float, std::size_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    paths_.assign(open.size(), kFar);
    paths_[start] = 0;
    queue.emplace(0.0F, start);
    while (!queue.empty()) {
      const Entry entry = queue.top();
      queue.pop();
      if (entry.first > paths_[entry.second]) continue;
      visit_neighbours(entry.second, kNeighbours.size(), [&](std::size_t next, std::size_t i) {
        const float length = entry.first + (i < kSides ? 1.0F : kDiagonal);
        if (open[next] == 0 || length >= paths_[next]) return;
        paths_[next] = length;
        queue.emplace(length, next);
      });
    }
  }

  /// Those among the wide cells that open ones connect with the start.
  void find_frontier_cells(const std::vector<std::uint8_t>& open, const std::vector<std::uint8_t>& wide,
                           std::size_t start) {
    belongs_.assign(open.size(), kNone);
    reached_.assign(open.size(), 0);
    std::vector<std::size_t> queue{start};
    reached_[start] = 1;
    for (std::size_t i = 0; i < queue.size(); ++i) {
      visit_neighbours(queue[i], kSides, [&](std::size_t next, std::size_t) {
        if (open[next] == 0 || reached_[next] != 0) return;
        reached_[next] = 1;
        queue.push_back(next);
      });
      if (wide[queue[i]] == 0 || !is_at_border(queue[i]) || !in_bounds(queue[i])) continue;
      belongs_[queue[i]] = kFree;
      frontier_cells_.push_back(queue[i]);
    }
  }

  /// Whether a cell is known, not lethal, and has a side in common with an unknown one.
  [[nodiscard]] bool is_at_border(std::size_t index) const {
    if (costs_.cells[index] == kUnknownCost || costs_.cells[index] == kLethalCost) return false;
    bool at_border = false;
    visit_neighbours(index, kSides, [&](std::size_t next, std::size_t) {
      at_border = at_border || costs_.cells[next] == kUnknownCost;
    });
    return at_border;
  }

  [[nodiscard]] bool in_bounds(std::size_t index) const {
    return query_.bounds_m.empty() || contains(query_.bounds_m, costs_.middle_of(cell_at(index)));
  }

  /// Connected frontier cells, no more than the greatest length; those of other clusters are not taken.
  [[nodiscard]] std::vector<std::size_t> take_cluster(std::size_t first) {
    const auto max_count =
        static_cast<std::size_t>(std::max(1.0, params_.max_length_m / costs_.resolution_m));
    std::vector<std::size_t> cluster{first};
    belongs_[first] = kTaken;
    for (std::size_t i = 0; i < cluster.size(); ++i)
      visit_neighbours(cluster[i], kNeighbours.size(), [&](std::size_t next, std::size_t) {
        if (belongs_[next] != kFree || cluster.size() >= max_count) return;
        belongs_[next] = kTaken;
        cluster.push_back(next);
      });
    return cluster;
  }

  /// Cells of the border that go on from a cluster towards obstacles, where the inscribed circle cannot be.
  [[nodiscard]] std::size_t count_beside(const std::vector<std::size_t>& cluster) {
    ++visit_;
    for (const std::size_t index : cluster) visits_[index] = visit_;
    std::vector<std::size_t> queue = cluster;
    std::size_t begin = 0;
    for (int step = 0; step < static_cast<int>(radius_m_ / costs_.resolution_m); ++step)
      for (const std::size_t end = queue.size(); begin < end; ++begin)
        visit_neighbours(queue[begin], kNeighbours.size(), [&](std::size_t next, std::size_t) {
          if (visits_[next] == visit_ || belongs_[next] != kNone || !is_at_border(next)) return;
          visits_[next] = visit_;
          queue.push_back(next);
        });
    return queue.size() - cluster.size();
  }

  void add(const std::vector<std::size_t>& cluster, FrontierList& list) {
    Frontier frontier;
    frontier.length_m = static_cast<double>(cluster.size() + count_beside(cluster)) * costs_.resolution_m;
    if (frontier.length_m < params_.min_length_m) return;
    frontier.points_m.reserve(cluster.size());
    for (const std::size_t index : cluster) {
      frontier.points_m.push_back(costs_.middle_of(cell_at(index)));
      frontier.centroid_m += frontier.points_m.back() / static_cast<double>(cluster.size());
    }
    if (!find_goal(cluster, frontier)) {
      ++list.without_goal;
      return;
    }
    const Vector2d goal_m(frontier.goal.x, frontier.goal.y);
    if (std::any_of(query_.blacklist_m.begin(), query_.blacklist_m.end(), [&](const Vector2d& failed_m) {
          return (failed_m - goal_m).norm() <= params_.blacklist_radius_m;
        })) {
      ++list.blacklisted;
      return;
    }
    frontier.score = params_.gain_weight * frontier.length_m - frontier.path_m;
    list.frontiers.push_back(std::move(frontier));
  }

  /// The first cell around the frontier's middle where the footprint fits.
  [[nodiscard]] bool find_goal(const std::vector<std::size_t>& cluster, Frontier& frontier) {
    std::size_t middle = 0;
    for (std::size_t i = 1; i < cluster.size(); ++i)
      if ((frontier.points_m[i] - frontier.centroid_m).norm() <
          (frontier.points_m[middle] - frontier.centroid_m).norm())
        middle = i;
    const Vector2d target_m = frontier.points_m[middle];
    const auto goal = search(
        cluster[middle], params_.max_standoff_m, [&](std::size_t i) { return reached_[i] != 0; },
        [&](std::size_t i) { return paths_[i] < kFar && fits(i, target_m, frontier.goal); });
    if (goal) frontier.path_m = paths_[*goal] * costs_.resolution_m;
    return goal.has_value();
  }

  /// Whether the footprint fits at a cell, best heading first: towards the target, then rotated by steps.
  [[nodiscard]] bool fits(std::size_t index, const Vector2d& target_m, Pose2& goal) const {
    constexpr std::array<double, 8> kRotations{0, 0.25, -0.25, 0.5, -0.5, 0.75, -0.75, 1};
    const Vector2d position_m = costs_.middle_of(cell_at(index));
    const Vector2d ahead = target_m - position_m;
    const double heading = ahead.isZero(0) ? query_.start.yaw : std::atan2(ahead.y(), ahead.x());
    for (const double rotation : kRotations) {
      const Pose2 pose{position_m.x(), position_m.y(), wrap_angle(heading + rotation * kPi)};
      const Contact touched = contact(costs_, footprint_, pose);
      if (touched == Contact::kObstacle || (touched == Contact::kUnknown && !params_.allow_unknown)) continue;
      goal = pose;
      return true;
    }
    return false;
  }

  const CostGrid& costs_;
  const Footprint& footprint_;
  const FrontierQuery& query_;
  const FrontierParams& params_;
  const double radius_m_;
  std::vector<std::uint32_t> visits_;  ///< the last search that was at a cell
  std::uint32_t visit_{0};
  std::vector<float> paths_;  ///< length from the start [cells]
  std::vector<std::uint8_t> reached_;
  std::vector<Belongs> belongs_;
  std::vector<std::size_t> frontier_cells_;
};

bool is_valid(const FrontierParams& params) {
  return params.min_length_m > 0 && params.max_length_m >= params.min_length_m && params.gain_weight >= 0 &&
         params.max_standoff_m > 0 && params.start_tolerance_m >= 0 && params.blacklist_radius_m >= 0 &&
         params.passage_slack_m >= 0;
}

}  // namespace

NavResult<FrontierList> find_frontiers(const CostGrid& costs, const Footprint& footprint,
                                       const FrontierQuery& query, const FrontierParams& params) {
  if (!is_valid(params))
    return nav_fail(NavCode::kInvalidRequest, "exploration: a parameter is out of its range");
  if (!is_finite(query.start) || !std::all_of(query.bounds_m.begin(), query.bounds_m.end(),
                                              [](const Vector2d& p) { return p.allFinite(); }))
    return nav_fail(NavCode::kInvalidRequest, "exploration: start and bounds must be finite");
  if (costs.empty()) return nav_fail(NavCode::kNoMap, "exploration: there is no map");
  if (!costs.cell_of({query.start.x, query.start.y}))
    return nav_fail(NavCode::kStartOutside,
                    "exploration: the robot is not on the map; check its localization", query.start);
  return FrontierSearch(costs, footprint, query, params).run();
}

}  // namespace extperfc::navigate
