#include "test/benchmark/map/world_kinds.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "test/benchmark/map/corridor.hpp"

namespace extperfc::benchmark {
namespace {

using Point = Eigen::Vector2d;

constexpr double kGridPathM = 600;
constexpr double kLongGridPathM = 1900;
constexpr double kNoOdometryFraction = 0.12;  // of the drives, where the kind allows it
constexpr double kGlassFraction = 0.15;       // of the walls, where there is glass
constexpr std::uint64_t kSeedStep = 1'000'003;
constexpr std::uint64_t kKindStep = 7'777;

WorldScanner random_scanner(Rng& rng) {
  constexpr double kRevolution = 2 * M_PI;
  struct Model {
    int rays;
    double angle_min;
    double angle_increment;
  };
  constexpr std::array<Model, 4> kModels{{{180, -kRevolution / 4, kRevolution / 360},
                                          {361, -kRevolution / 4, kRevolution / 720},
                                          {541, -3 * kRevolution / 8, kRevolution / 720},
                                          {360, -kRevolution / 2, kRevolution / 360}}};
  constexpr std::array<double, 3> kRangesM{8, 30, 80};
  const Model& model = kModels[static_cast<std::size_t>(rng.integer(0, 3))];
  WorldScanner scanner;
  scanner.rays = model.rays;
  scanner.angle_min = model.angle_min;
  scanner.angle_increment = model.angle_increment;
  scanner.range_max_m = kRangesM[static_cast<std::size_t>(rng.integer(0, 2))];
  scanner.sigma_m = rng.uniform(0.008, 0.025);
  scanner.outlier_fraction = rng.chance(0.3) ? 0.01 : 0.0;
  return scanner;
}

/// From good wheels to slipping ones.
WorldOdometry random_odometry(Rng& rng) {
  struct Wheels {
    double min_scale, max_scale;
    double min_veer, max_veer;  // [rad/m]
  };
  constexpr std::array<Wheels, 5> kWheels{{{0.005, 0.005, 0.001, 0.001},
                                           {0.012, 0.012, 0.003, 0.003},
                                           {0.01, 0.03, 0, 0.01},
                                           {0.02, 0.05, 0, 0.02},
                                           {0, 0.01, 0.005, 0.03}}};
  const Wheels& wheels = kWheels[static_cast<std::size_t>(rng.integer(0, 4))];
  const auto draw = [&](double low, double high) { return low < high ? rng.uniform(low, high) : low; };
  WorldOdometry odometry;
  odometry.sigma_m_per_sqrt_m = rng.uniform(0.003, 0.018);
  odometry.sigma_rad_per_sqrt_m = rng.uniform(0.0025, 0.015);
  odometry.rotation_scale = odometry.sigma_rad_per_sqrt_rad = rng.uniform(0.003, 0.018);
  const double scale_sign = rng.chance(0.5) ? 1 : -1;
  const double veer_sign = rng.chance(0.5) ? 1 : -1;
  odometry.scale = scale_sign * draw(wheels.min_scale, wheels.max_scale);
  odometry.veer_rad_per_m = veer_sign * draw(wheels.min_veer, wheels.max_veer);
  return odometry;
}

/// Draws a building: first what all kinds have in common, then the plan.
class Planner {
 public:
  using Plan = void (Planner::*)();

  explicit Planner(std::uint64_t seed) : rng_(seed) {
    draw_robot();
    world_.odometry = random_odometry(rng_);
    const double width = rng_.uniform(1.8, 2.8);
    look_ = random_look(CorridorKind::kCommon, width, rng_);
  }

  [[nodiscard]] WorldCase make(Plan plan, bool may_lack_odometry) {
    (this->*plan)();
    if (may_lack_odometry && rng_.chance(kNoOdometryFraction)) world_.odometry.there = false;
    if (world_.pedestrians == 0 && rng_.chance(0.2)) world_.pedestrians = 2;
    world_.floor.close(glass_fraction_, rng_);
    return std::move(world_);
  }

  void ring_twice();
  void sparse_ring();
  void poor_scanner();
  void loop_then_end();
  void eight();
  void grid();
  void long_grid();
  void out_and_back();
  void desks();
  void big_loop();
  void lobby();

 private:
  void draw_robot();
  void redraw_look(CorridorKind last_kind);
  void corridor(const Point& start, const Point& end) { add_corridor(world_.floor, start, end, look_, rng_); }
  void rectangle(double length, double height);
  void ring(double length, double height, int laps, double beyond_m);
  void go(const std::vector<Point>& corners) {
    world_.route.insert(world_.route.end(), corners.begin(), corners.end());
  }
  [[nodiscard]] std::vector<double> meshes(int count, double narrowest_m, double widest_m);
  void drive_grid(const std::vector<double>& columns, const std::vector<double>& rows, double path_m);
  void wander(const std::vector<double>& columns, const std::vector<double>& rows, double long_m);
  void office(double left, double width, double door);
  void lobby_pillar(double length, double height);

  Rng rng_;
  WorldCase world_;
  CorridorLook look_;
  double glass_fraction_{0};
};

void Planner::draw_robot() {
  world_.scanner = random_scanner(rng_);
  world_.step_m = rng_.uniform(0.06, 0.22);
  world_.scanner.base_T_sensor.x = rng_.uniform(0, 0.3);
  world_.wander_m = rng_.uniform(0.05, 0.3);
}

void Planner::redraw_look(CorridorKind last_kind) {
  const auto kind = static_cast<CorridorKind>(rng_.integer(0, static_cast<int>(last_kind)));
  look_ = random_look(kind, look_.width_m, rng_);
}

void Planner::rectangle(double length, double height) {
  const std::array<Point, 4> corners{{{0, 0}, {length, 0}, {length, height}, {0, height}}};
  for (std::size_t i = 0; i < 4; ++i) corridor(corners[i], corners[(i + 1) % 4]);
}

/// Around `laps` times from 5 m behind a corner, and on.
void Planner::ring(double length, double height, int laps, double beyond_m) {
  rectangle(length, height);
  go({{5, 0}});
  for (int lap = 0; lap < laps; ++lap) {
    go({{length, 0}, {length, height}, {0, height}, {0, 0}});
    if (lap + 1 < laps) go({{5, 0}});
  }
  go({{5 + beyond_m, 0}});
}

void Planner::ring_twice() {
  redraw_look(CorridorKind::kAlike);
  world_.odometry.scale = 0.01;
  world_.scanner.rays = 180;
  world_.scanner.range_max_m = 8;
  const bool full_revolution = rng_.chance(0.5);
  world_.scanner.angle_min = full_revolution ? -M_PI : -M_PI / 2;
  world_.scanner.angle_increment = full_revolution ? M_PI / 90 : M_PI / 180;
  const double length = rng_.uniform(40, 160);
  const double height = rng_.uniform(25, 120);
  ring(length, height, 2, 8);
}

void Planner::sparse_ring() {
  look_ = random_look(CorridorKind::kSparse, look_.width_m, rng_);
  const double height = rng_.uniform(30, 80);
  const double length = rng_.uniform(40, 110);
  ring(length, height, 2, 12);
}

void Planner::poor_scanner() {
  draw_robot();
  world_.scanner.range_max_m = 5;
  world_.scanner.sigma_m = 0.04;
  world_.scanner.rays = 121;
  world_.scanner.angle_min = -2 * M_PI / 3;
  world_.scanner.angle_increment = M_PI / 90;
  const double height = rng_.uniform(20, 40);
  const double length = rng_.uniform(25, 60);
  ring(length, height, 2, 10);
}

void Planner::loop_then_end() {
  const double length = rng_.uniform(30, 90);
  const double height = rng_.uniform(25, 60);
  redraw_look(CorridorKind::kSparse);
  ring(length, height, 1, rng_.uniform(2, 14));
}

void Planner::eight() {
  const double first = rng_.uniform(25, 60);
  const double both = first + rng_.uniform(25, 60);
  const double height = rng_.uniform(25, 50);
  look_.room_fraction = rng_.uniform(0, 0.3);
  const Point a(0, 0);
  const Point b(first, 0);
  const Point c(first, height);
  const Point d(0, height);
  const Point e(both, 0);
  const Point f(both, height);
  rectangle(first, height);
  corridor(b, e);
  corridor(e, f);
  corridor(f, c);
  go({{4, 0}, b, c, d, a, b, e, f, c, b, a, d, c, f, e, b, {6, 0}});
}

/// Where the corridors of a grid lie.
std::vector<double> Planner::meshes(int count, double narrowest_m, double widest_m) {
  std::vector<double> lines{0};
  for (int i = 0; i < count; ++i) lines.push_back(lines.back() + rng_.uniform(narrowest_m, widest_m));
  return lines;
}

void Planner::grid() {
  const int count = rng_.integer(2, 3);
  const auto columns = meshes(count, 18, 45);
  drive_grid(columns, meshes(2, 18, 40), kGridPathM);
}

void Planner::long_grid() {
  redraw_look(rng_.chance(0.5) ? CorridorKind::kAlike : CorridorKind::kSparse);
  const int count = rng_.integer(2, 3);
  const auto columns = meshes(count, 35, 108);
  drive_grid(columns, meshes(2, 35, 96), kLongGridPathM);
}

void Planner::drive_grid(const std::vector<double>& columns, const std::vector<double>& rows, double path_m) {
  look_.room_fraction = rng_.uniform(0, 0.3);
  world_.pedestrians = rng_.integer(0, 4);
  glass_fraction_ = rng_.chance(0.4) ? kGlassFraction : 0.0;
  for (const double y : rows)
    for (std::size_t i = 1; i < columns.size(); ++i) corridor({columns[i - 1], y}, {columns[i], y});
  for (const double x : columns)
    for (std::size_t j = 1; j < rows.size(); ++j) corridor({x, rows[j - 1]}, {x, rows[j]});
  wander(columns, rows, path_m);
}

/// From intersection to intersection, never straight back.
void Planner::wander(const std::vector<double>& columns, const std::vector<double>& rows, double long_m) {
  using Intersection = std::pair<int, int>;
  const auto there = [&](const Intersection& c) {
    return c.first >= 0 && c.second >= 0 && c.first < static_cast<int>(columns.size()) &&
           c.second < static_cast<int>(rows.size());
  };
  const auto place = [&](const Intersection& c) {
    return Point(columns[static_cast<std::size_t>(c.first)], rows[static_cast<std::size_t>(c.second)]);
  };
  Intersection last{-1, -1};
  Intersection now{0, 0};
  go({place(now)});
  for (double path_m = 0; path_m < long_m;) {
    const auto& [i, j] = now;
    std::vector<Intersection> choice;
    for (const Intersection& next : {Intersection{i - 1, j}, {i + 1, j}, {i, j - 1}, {i, j + 1}})
      if (there(next) && next != last) choice.push_back(next);
    last = now;
    now = choice[static_cast<std::size_t>(rng_.integer(0, static_cast<int>(choice.size()) - 1))];
    path_m += (place(now) - place(last)).norm();
    go({place(now)});
  }
}

void Planner::out_and_back() {
  redraw_look(CorridorKind::kAlike);
  const double length = rng_.uniform(80, 250);
  const double branch = rng_.uniform(10, 40);
  const double x = length * rng_.uniform(0.3, 0.7);
  corridor({0, 0}, {length, 0});
  corridor({x, 0}, {x, branch});
  go({{2, 0}, {length - 2, 0}, {x, 0}, {x, branch - 2}, {x, 0}, {2, 0}, {0.8 * x, 0}});
}

/// A room below the lowest corridor with two desks and their chairs; the robot looks into most of them.
void Planner::office(double left, double width, double door) {
  const double wall = -look_.width_m / 2;
  world_.floor.add_floor({left, wall - 5.2}, {left + width, wall - 0.2});
  world_.floor.add_floor({left + 1, wall - 0.3}, {left + 1 + door, wall + 0.05});
  for (const double desk : {left + 0.4, left + 0.4 + (width - 2.2)}) {
    world_.floor.add_box({desk, wall - 4.8}, {desk + 1.4, wall - 4.1});
    world_.floor.add_box({desk + 0.4, wall - 4.0}, {desk + 0.8, wall - 3.6});
  }
  const double middle = left + 1 + door / 2;
  if (rng_.chance(0.7)) go({{middle, 0}, {middle, wall - 2}, {middle, 0}});
}

void Planner::desks() {
  const double length = rng_.uniform(30, 60);
  const double height = rng_.uniform(30, 45);
  rectangle(length, height);
  const double width = rng_.uniform(4, 6);
  const double door = rng_.uniform(0.9, 1.2);
  go({{3, 0}});
  for (double left = 3; left + width < length - 3; left += width + 0.2) office(left, width, door);
  go({{length, 0}, {length, height}, {0, height}, {0, 0}});
  go({{length, 0}, {length, height}, {length / 2, height}});
  world_.wander_m = std::min(world_.wander_m, 0.1);  // doors are narrow
}

void Planner::big_loop() {
  redraw_look(CorridorKind::kSparse);
  const double length = rng_.uniform(120, 230);
  const double height = rng_.uniform(50, 120);
  look_.room_fraction = rng_.uniform(0, 0.2);
  world_.pedestrians = rng_.integer(0, 3);
  const double x = length * rng_.uniform(0.3, 0.7);
  corridor({x, 0}, {x, height});
  rectangle(length, height);
  go({{5, 0}, {length, 0}, {length, height}, {0, height}, {0, 0}, {x, 0}, {x, height}, {0.5 * x, height}});
  world_.step_m = std::max(world_.step_m, 0.12);
}

/// Off the robot's route.
void Planner::lobby_pillar(double length, double height) {
  const double x = rng_.uniform(4, length - 4);
  const double y = rng_.uniform(4, height - 4);
  const double side = rng_.uniform(0.3, 0.8);
  const double from_round = std::min({x - 2, length - 2 - x, y - 2, height - 2 - y});
  if (std::abs(y - height / 2) > 1.8 && from_round > 1.5) world_.floor.add_box({x, y}, {x + side, y + side});
}

void Planner::lobby() {
  const double length = rng_.uniform(30, 60);
  const double height = rng_.uniform(20, 40);
  const double middle = height / 2;
  world_.floor.add_floor({0, 0}, {length, height});
  const int pillars = rng_.integer(2, 8);
  for (int i = 0; i < pillars; ++i) lobby_pillar(length, height);
  look_ = random_look(CorridorKind::kCommon, look_.width_m, rng_);
  corridor({-50, middle}, {2, middle});
  world_.pedestrians = rng_.integer(0, 3);
  go({{-45, middle}, {2, middle}, {2, 2}, {length - 2, 2}, {length - 2, height - 2}, {2, height - 2}});
  go({{2, middle}, {length - 3, middle}, {2, middle}, {-40, middle}, {2, middle}, {2, 2}, {length / 2, 2}});
}

struct Kind {
  const char* name;
  Planner::Plan plan;
  bool may_lack_odometry;
};

constexpr std::array<Kind, 10> kKinds{{{"ring_twice", &Planner::ring_twice, false},
                                       {"sparse_ring", &Planner::sparse_ring, false},
                                       {"poor_scanner", &Planner::poor_scanner, false},
                                       {"loop_then_end", &Planner::loop_then_end, true},
                                       {"eight", &Planner::eight, true},
                                       {"grid", &Planner::grid, true},
                                       {"out_and_back", &Planner::out_and_back, true},
                                       {"desks", &Planner::desks, true},
                                       {"big_loop", &Planner::big_loop, true},
                                       {"lobby", &Planner::lobby, true}}};
constexpr Kind kLongKind{kLongGrid, &Planner::long_grid, false};

}  // namespace

const std::vector<std::string>& world_kinds() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Kind& kind : kKinds) all.emplace_back(kind.name);
    return all;
  }();
  return names;
}

Result<WorldCase> make_world(const std::string& kind, std::uint64_t seed) {
  if (kind == kLongKind.name)
    return Planner(seed * kSeedStep + kKinds.size() * kKindStep + 5)
        .make(kLongKind.plan, kLongKind.may_lack_odometry);
  for (std::size_t i = 0; i < kKinds.size(); ++i)
    if (kKinds[i].name == kind)
      return Planner(seed * kSeedStep + i * kKindStep + 5).make(kKinds[i].plan, kKinds[i].may_lack_odometry);
  return fail(ErrorCode::kInvalidArgument, "no kind of building is called '" + kind + "'");
}

}  // namespace extperfc::benchmark
