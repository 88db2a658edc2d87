#include "test/benchmark/navigate/control_cases.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "extperfc/base/rng.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/navigate/collision_guard.hpp"
#include "extperfc/navigate/local_planner.hpp"

#include "test/benchmark/navigate/dwa_peer.hpp"
#include "test/support/drive_simulation.hpp"

namespace extperfc::benchmark {

namespace {

using navigate::BaseKind;
using navigate::LocalPlanner;
using navigate::MppiParams;
using navigate::Path;

constexpr double kRate_hz = 20;
constexpr int kRoutesPerBuilding = 3;

struct Route {
  std::uint64_t seed{0};
  Building building;
  Path path;
  std::vector<Pedestrian> people;
};

/// Random places that a route with the footprint joins.
std::vector<Route> routes_of(std::uint64_t seed, int people) {
  const Building building = BuildingGenerator(seed).make();
  navigate::CostGrid grid = rasterized(building, 0.05);
  grid.may_hold_unknown = false;
  inflate(grid, {chassis().inscribed_radius_m(), 1.0, 5});
  GridRoute planner(grid);
  Rng rng(seed);
  const auto place = [&] {
    return Eigen::Vector2d(rng.uniform(0.7, building.size_m.x() - 0.7),
                           rng.uniform(0.7, building.size_m.y() - 0.7));
  };
  std::vector<Route> routes;
  routes.reserve(kRoutesPerBuilding);
  for (int attempt = 0; attempt < 300 && routes.size() < kRoutesPerBuilding; ++attempt) {
    const Eigen::Vector2d start = place();
    const Eigen::Vector2d goal = place();
    if ((start - goal).norm() < 4) continue;
    auto path = planner.plan(chassis(), start, goal);
    if (!path) continue;
    Route route{seed * 100 + routes.size(), building, std::move(*path), {}};
    for (int i = 0; i < 60 && route.people.size() < static_cast<std::size_t>(people); ++i) {
      const Eigen::Vector2d from = place();
      const Eigen::Vector2d to = place();
      if ((from - to).norm() < 4 || (from - start).norm() < 2) continue;
      if (const auto walk = planner.plan(navigate::Footprint::circle(0.25), from, to))
        route.people.push_back(make_pedestrian(*walk, rng.uniform(0.4, 1.2)));
    }
    routes.push_back(std::move(route));
  }
  return routes;
}

std::unique_ptr<LocalPlanner> planner_of(BaseKind base, bool peer) {
  MppiParams params;
  params.base = base;
  if (base == BaseKind::kDifferential) params.limits.max_vy_m_s = 0;
  return peer ? make_dwa(params.limits, base) : make_mppi_planner(params);
}

struct Series {
  int drives{0};
  int reached{0};
  int contacts{0};
  int person_contacts{0};
  double driven_m{0};
  double planned_m{0};
  double fast_m{0};
  double fast_s{0};
  std::vector<double> swing_m;
  std::vector<double> cycle_s;

  void add(const DriveResult& result) {
    ++drives;
    contacts += result.contacts;
    person_contacts += result.person_contacts;
    cycle_s.insert(cycle_s.end(), result.cycle_s.begin(), result.cycle_s.end());
    if (!result.reached) return;
    ++reached;
    driven_m += result.driven_m;
    planned_m += result.planned_m;
    fast_m += result.mean_speed_m_s * result.time_s;
    fast_s += result.time_s;
    swing_m.push_back(std::max(0.0, result.swing_m));
  }
};

double quantile(std::vector<double> values, double part) {
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? NAN : sum / static_cast<double>(values.size());
}

Series drive_all(const std::vector<Route>& routes, BaseKind base, bool peer) {
  Series series;
  for (const Route& route : routes) {
    DriveOptions options;
    options.max_time_s = 60 + 4 * length_m(route.path);
    DriveSimulation simulation(route.building, chassis(), options, route.seed);
    simulation.people = route.people;
    const auto planner = planner_of(base, peer);
    series.add(simulation.drive(*planner, route.path, {}, route.path.poses.front()));
  }
  return series;
}

void add_rows(const std::string& name, const Series& ours, const Series& peer, bool people,
              std::vector<Row>& rows) {
  const auto row = [&](const char* metric, const char* unit, double our, double other) {
    return Row{name, metric, unit, our, other, "DWA"};
  };
  rows.push_back(at_least(row("goals reached", "", ours.reached, peer.reached), ours.drives));
  rows.push_back(at_most(row("contacts with the building", "", ours.contacts, peer.contacts), 0));
  if (people)
    rows.push_back(at_most(row("contacts with people", "", ours.person_contacts, peer.person_contacts), 0));
  const Row speed = row("mean speed", "m/s", ours.fast_m / ours.fast_s, peer.fast_m / peer.fast_s);
  rows.push_back(people ? speed : at_least(speed, 0.45));
  const Row ratio =
      row("driven / planned", "", ours.driven_m / ours.planned_m, peer.driven_m / peer.planned_m);
  rows.push_back(people ? ratio : at_most(ratio, 1.1));
  rows.push_back(
      row("swing at the goal, largest", "m", quantile(ours.swing_m, 1), quantile(peer.swing_m, 1)));
}

/// A scan of 1,000 points in a room.
void measure_guard(std::vector<Row>& rows) {
  Rng rng(1);
  std::vector<Eigen::Vector2d> points;
  points.reserve(1000);
  for (int i = 0; i < 1000; ++i) {
    const double angle = kTwoPi * i / 1000;
    const double range = rng.uniform(0.8, 4);
    points.emplace_back(range * std::cos(angle), range * std::sin(angle));
  }
  navigate::CollisionGuard guard({});
  guard.set_points(points, 0);
  std::vector<double> times_s;
  times_s.reserve(2000);
  for (int i = 0; i < 2000; ++i) {
    const Twist2 command{rng.uniform(-0.4, 0.8), rng.uniform(-0.5, 0.5), rng.uniform(-1, 1)};
    const CpuStopwatch watch;
    (void)guard.admit(chassis(), command, command, 0.05);
    times_s.push_back(watch.seconds());
  }
  rows.push_back({"last-moment stop, 1000 points", "p50", "us", 1e6 * quantile(times_s, 0.5)});
  rows.push_back({"last-moment stop, 1000 points", "p95", "us", 1e6 * quantile(times_s, 0.95)});
}

std::vector<Route> routes_in(const ControlOptions& options, int buildings, int people) {
  std::vector<Route> routes;
  for (int i = 0; i < buildings; ++i)
    for (Route& route : routes_of(options.first_seed + static_cast<std::uint64_t>(i), people))
      routes.push_back(std::move(route));
  return routes;
}

}  // namespace

void measure_control(const ControlOptions& options, std::vector<Row>& rows) {
  const std::vector<Route> routes = routes_in(options, options.quick ? 1 : 3, 3);
  for (const BaseKind base : {BaseKind::kHolonomic, BaseKind::kDifferential}) {
    const std::string name =
        std::string("control cycle, ") + (base == BaseKind::kHolonomic ? "holonomic" : "differential");
    const Series ours = drive_all(routes, base, false);
    const Series peer = drive_all(routes, base, true);
    const auto row = [&](const char* metric, const char* unit, double our, double other) {
      return Row{name, metric, unit, our, other, "DWA"};
    };
    rows.push_back(row("p50", "ms", 1e3 * quantile(ours.cycle_s, 0.5), 1e3 * quantile(peer.cycle_s, 0.5)));
    rows.push_back(at_most(
        row("p95", "ms", 1e3 * quantile(ours.cycle_s, 0.95), 1e3 * quantile(peer.cycle_s, 0.95)), 20));
    rows.push_back(at_most(
        row("core at 20 Hz", "%", 100 * kRate_hz * mean(ours.cycle_s), 100 * kRate_hz * mean(peer.cycle_s)),
        15));
  }
  measure_guard(rows);
}

void measure_drives(const ControlOptions& options, std::vector<Row>& rows) {
  for (const int people : {0, 5}) {
    const std::vector<Route> routes = routes_in(options, options.quick ? 2 : 10, people);
    for (const BaseKind base : {BaseKind::kHolonomic, BaseKind::kDifferential}) {
      const std::string name = std::to_string(routes.size()) + " drives, " +
                               (base == BaseKind::kHolonomic ? "holonomic" : "differential") +
                               (people > 0 ? ", 5 people" : "");
      add_rows(name, drive_all(routes, base, false), drive_all(routes, base, true), people > 0, rows);
    }
  }
}

}  // namespace extperfc::benchmark
