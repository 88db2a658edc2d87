#include "test/benchmark/navigate/plan_cases.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <string>

#include <malloc.h>
#include <unistd.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/navigate/global_planner.hpp"
#include "extperfc/world/map_file.hpp"

#include "test/benchmark/navigate/office_map.hpp"
#include "test/benchmark/navigate/plan_peers.hpp"
#include "test/benchmark/navigate/shortest_path.hpp"

namespace extperfc::benchmark {

namespace {

using navigate::Contact;
using navigate::CostGrid;
using navigate::Footprint;
using navigate::GlobalPlanner;
using navigate::GridPlannerParams;

constexpr double kInflation_m = 1.0;
constexpr double kScaling_per_m = 5.0;
constexpr double kMargin_m = 0.035;  // queries: reachable through doors with this much on both sides

/// The robot's chassis.
Footprint chassis() {
  return *Footprint::make({{0.4064, 0.3937}, {-0.4064, 0.3937}, {-0.4064, -0.3937}, {0.4064, -0.3937}});
}

/// For lengths: what is blocked for its middle does not depend on its yaw.
Footprint round_base() {
  return Footprint::circle(0.35);
}

struct Query {
  Pose2 start;
  Pose2 goal;
};

/// Free poses at corners of cells, so that the reference begins and ends there too.
std::vector<Query> make_queries(const CostGrid& costs, const Footprint& footprint, int count,
                                std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Pose2> poses;
  for (const Eigen::Vector2d& place : random_places(costs, 20 * count, seed, kMargin_m)) {
    const Pose2 pose{place.x() - 0.5 * costs.resolution_m, place.y() - 0.5 * costs.resolution_m,
                     rng.uniform(-3.14, 3.14)};
    if (contact(costs, footprint, pose) == Contact::kFree) poses.push_back(pose);
  }
  std::vector<Query> queries;
  for (std::size_t k = 0; k + 1 < poses.size() && queries.size() < static_cast<std::size_t>(count); k += 2)
    queries.push_back({poses[k], poses[k + 1]});
  return queries;
}

struct Series {
  std::vector<double> ms;        ///< CPU time
  std::vector<double> length_m;  ///< NaN: failed
  int failed{0};
  int touching{0};  ///< paths with a contact on or between poses

  [[nodiscard]] double mean_ms() const {
    double sum = 0;
    for (const double value : ms) sum += value;
    return sum / static_cast<double>(std::max<std::size_t>(1, ms.size()));
  }
  [[nodiscard]] double p95_ms() const {
    std::vector<double> copy = ms;
    return percentile(copy, 0.95);
  }
};

bool touches(const CostGrid& costs, const Footprint& footprint, const navigate::Path& path) {
  for (std::size_t i = 1; i < path.poses.size(); ++i)
    if (contact_along(costs, footprint, path.poses[i - 1], path.poses[i]) != Contact::kFree) return true;
  return false;
}

void run(GlobalPlanner& planner, const CostGrid& costs, const Footprint& footprint,
         const std::vector<Query>& queries, Series& series) {
  for (const Query& query : queries) {
    const CpuStopwatch watch;
    const auto path = planner.plan(costs, footprint, {query.start, query.goal});
    series.ms.push_back(1e3 * watch.seconds());
    series.length_m.push_back(path ? length_m(*path) : std::nan(""));
    series.failed += path ? 0 : 1;
    if (path && touches(costs, footprint, *path)) ++series.touching;
    if (!path) std::cerr << "  " << to_string(path.error().code) << ": " << path.error().message << "\n";
  }
}

/// Ratios to exact shortest paths [-].
struct Ratios {
  std::vector<double> values;
  double ours_m{0};
  double exact_m{0};

  void add(double ours, double exact) {
    if (!std::isfinite(ours) || !std::isfinite(exact) || exact < 1) return;
    values.push_back(ours / exact);
    ours_m += ours;
    exact_m += exact;
  }
};

void compare(ShortestPath& reference, const CostGrid& costs, const std::vector<Query>& queries,
             const std::vector<double>& length_m, Ratios& ratios) {
  const auto vertex = [&](const Pose2& pose) {
    return ShortestPath::Vertex{
        static_cast<int>(std::lround((pose.x - costs.origin_m.x()) / costs.resolution_m)),
        static_cast<int>(std::lround((pose.y - costs.origin_m.y()) / costs.resolution_m))};
  };
  for (std::size_t k = 0; k < queries.size(); ++k)
    if (std::isfinite(length_m[k]))
      ratios.add(length_m[k], reference.length_m(vertex(queries[k].start), vertex(queries[k].goal)));
}

GridPlannerParams shortest() {
  GridPlannerParams params;
  params.cost_factor = 0;
  return params;
}

struct Floor {
  CostGrid costs;
  std::vector<Query> queries;
  CostGrid round_costs;  ///< inflated for the round base
  std::vector<Query> round_queries;
};

Floor make_floor(CostGrid grid, int count, std::uint64_t seed, bool round = true) {
  Floor floor;
  if (round) {
    floor.round_costs = grid;
    inflate(floor.round_costs, round_base().inscribed_radius_m(), kInflation_m, kScaling_per_m);
    floor.round_queries = make_queries(floor.round_costs, round_base(), count, seed);
  }
  floor.costs = std::move(grid);
  inflate(floor.costs, chassis().inscribed_radius_m(), kInflation_m, kScaling_per_m);
  floor.queries = make_queries(floor.costs, chassis(), count, seed);
  return floor;
}

Row with_peer(const std::string& name, const std::string& metric, const std::string& unit, double ours,
              double peer, const std::string& peer_name) {
  Row row{name, metric, unit, ours};
  row.peer = peer;
  row.peer_name = peer_name;
  return row;
}

/// Several buildings of one kind; the goals hold for the offices.
void floor_rows(const std::string& name, const std::vector<Floor>& floors, bool goals,
                std::vector<Row>& rows) {
  Series usual;
  Series of_shortest;
  Series differential;
  Series plain;
  Ratios ours;
  Ratios eight;
  const GridPlannerParams params;
  GridPlannerParams other;
  other.base = navigate::BaseKind::kDifferential;
  const auto planner = navigate::make_grid_planner(params);
  const auto length_planner = navigate::make_grid_planner(shortest());
  const auto differential_planner = navigate::make_grid_planner(other);
  DijkstraPlanner dijkstra(params.cost_factor / params.neutral_cost);
  DijkstraPlanner length_dijkstra(0);
  std::size_t count = 0;
  for (const Floor& floor : floors) {
    count += floor.queries.size();
    run(*planner, floor.costs, chassis(), floor.queries, usual);
    run(*differential_planner, floor.costs, chassis(), floor.queries, differential);
    run(dijkstra, floor.costs, chassis(), floor.queries, plain);
    Series lengths;
    Series eight_lengths;
    run(*length_planner, floor.round_costs, round_base(), floor.round_queries, lengths);
    run(length_dijkstra, floor.round_costs, round_base(), floor.round_queries, eight_lengths);
    ShortestPath reference(floor.round_costs);
    compare(reference, floor.round_costs, floor.round_queries, lengths.length_m, ours);
    compare(reference, floor.round_costs, floor.round_queries, eight_lengths.length_m, eight);
    of_shortest.ms.insert(of_shortest.ms.end(), lengths.ms.begin(), lengths.ms.end());
    of_shortest.failed += lengths.failed;
    of_shortest.touching += lengths.touching;
  }
  const std::string plain_name = "Dijkstra";
  const auto goal = [&](Row row, double limit) { return goals ? at_most(std::move(row), limit) : row; };
  rows.push_back(goal(with_peer(name, "plan, mean", "ms", usual.mean_ms(), plain.mean_ms(), plain_name), 40));
  rows.push_back(goal(with_peer(name, "plan, 95 %", "ms", usual.p95_ms(), plain.p95_ms(), plain_name), 80));
  rows.push_back(goal({name, "plan of shortest paths, mean", "ms", of_shortest.mean_ms()}, 40));
  rows.push_back(goal({name, "plan of shortest paths, 95 %", "ms", of_shortest.p95_ms()}, 80));
  rows.push_back({name, "differential base, mean", "ms", differential.mean_ms()});
  rows.push_back({name, "differential base, 95 %", "ms", differential.p95_ms()});
  rows.push_back(goal(with_peer(name, "length of all / exact", "-", ours.ours_m / ours.exact_m,
                                eight.ours_m / eight.exact_m, plain_name),
                      1.02));
  rows.push_back(with_peer(name, "length / exact, 95 %", "-", percentile(ours.values, 0.95),
                           percentile(eight.values, 0.95), plain_name));
  rows.push_back(with_peer(name, "length / exact, greatest", "-", percentile(ours.values, 1),
                           percentile(eight.values, 1), plain_name));
  const double plans = static_cast<double>(count);
  rows.push_back(with_peer(name, "found, of " + std::to_string(count), "plans", plans - usual.failed,
                           plans - plain.failed, plain_name));
  rows.push_back({name, "found, differential base", "plans", plans - differential.failed});
  rows.push_back(at_most(with_peer(name, "paths that touch", "plans",
                                   usual.touching + of_shortest.touching + differential.touching,
                                   plain.touching, plain_name + ", yaw 0"),
                         0));
}

/// Freed memory is given back before, so that differences count what is kept.
double resident_mib() {
  malloc_trim(0);
  long pages = 0;
  long resident = 0;
  if (FILE* file = std::fopen("/proc/self/statm", "r"); file != nullptr) {
    if (std::fscanf(file, "%ld %ld", &pages, &resident) != 2) resident = 0;
    std::fclose(file);
  }
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

void growth_rows(bool quick, std::vector<Row>& rows) {
  for (const int side : {1000, 2000, 4000, 8000}) {
    if (quick && side > 2000) continue;
    OfficeParams params;
    params.width = params.height = side;
    const int count = side > 2000 ? 20 : 50;
    const Floor floor = make_floor(make_office_map(params, 31), count, 5, false);
    const std::string name = "office " + std::to_string(side) + " x " + std::to_string(side);
    const double before_mib = resident_mib();
    Series ours;
    const auto planner = navigate::make_grid_planner({});
    run(*planner, floor.costs, chassis(), floor.queries, ours);
    const double mib = resident_mib() - before_mib;
    Series plain;
    DijkstraPlanner dijkstra(GridPlannerParams{}.cost_factor / GridPlannerParams{}.neutral_cost);
    const double before_plain_mib = resident_mib();
    run(dijkstra, floor.costs, chassis(), floor.queries, plain);
    rows.push_back(with_peer(name, "plan, mean", "ms", ours.mean_ms(), plain.mean_ms(), "Dijkstra"));
    rows.push_back(with_peer(name, "plan, 95 %", "ms", ours.p95_ms(), plain.p95_ms(), "Dijkstra"));
    rows.push_back(with_peer(name, "memory kept", "MiB", mib, resident_mib() - before_plain_mib, "Dijkstra"));
  }
}

void rrt_rows(const Floor& floor, std::vector<Row>& rows) {
  constexpr double kTime_s = 1.0;
  const std::vector<Query> queries(
      floor.queries.begin(), floor.queries.begin() + std::min<std::ptrdiff_t>(10, floor.queries.size()));
  Series ours;
  Series theirs;
  run(*navigate::make_grid_planner(shortest()), floor.costs, chassis(), queries, ours);
  run(*make_rrt_star(kTime_s), floor.costs, chassis(), queries, theirs);
  const std::string name = "office, 10 queries";
  rows.push_back(with_peer(name, "found", "plans", 10 - ours.failed, 10 - theirs.failed, "OMPL RRT*, 1 s"));
  rows.push_back(with_peer(name, "plan, mean", "ms", ours.mean_ms(), theirs.mean_ms(), "OMPL RRT*, 1 s"));
}

/// A map of map_server: lethal where occupied, unknown where unknown.
void real_map_rows(const PlanOptions& options, int count, std::vector<Row>& rows) {
  if (options.real_map.empty()) return;
  const auto map = load_map(options.real_map);
  if (!map) {
    std::cerr << "bench_navigate: " << map.error().message << "\n";
    return;
  }
  CostGrid grid = navigate::make_cost_grid(static_cast<int>(map->width), static_cast<int>(map->height),
                                           map->resolution_m, {0, 0}, navigate::kFreeCost);
  for (std::size_t i = 0; i < grid.cells.size(); ++i)
    grid.cells[i] = map->cells[i] < 0     ? navigate::kUnknownCost
                    : map->cells[i] >= 65 ? navigate::kLethalCost
                                          : navigate::kFreeCost;
  std::vector<Floor> floors;
  floors.push_back(make_floor(std::move(grid), count, 3));
  floor_rows(options.real_map.stem().string(), floors, false, rows);
}

}  // namespace

void measure_plans(const PlanOptions& options, std::vector<Row>& rows) {
  const int count = options.quick ? 40 : 100;
  const auto wanted = [&](const char* floors) { return options.floors.empty() || options.floors == floors; };
  if (wanted("office")) {
    std::vector<Floor> offices;
    for (const std::uint64_t seed : {11U, 12U, 13U})
      if (!options.quick || seed == 11U)
        offices.push_back(make_floor(make_office_map({}, seed), count, seed));
    floor_rows("office 2000 x 2000", offices, true, rows);
    rrt_rows(offices.front(), rows);
  }
  if (wanted("hall")) {
    std::vector<Floor> halls;
    halls.push_back(make_floor(make_hall_map(2000, 21), count, 21));
    floor_rows("hall 2000 x 2000", halls, false, rows);
  }
  if (wanted("maze")) {
    std::vector<Floor> mazes;
    mazes.push_back(make_floor(make_maze_map(2000, 1.6, 22), count, 22));
    floor_rows("maze 2000 x 2000", mazes, false, rows);
  }
  if (wanted("map")) real_map_rows(options, count, rows);
  if (wanted("growth")) growth_rows(options.quick, rows);
}

}  // namespace extperfc::benchmark
