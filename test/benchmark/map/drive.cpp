#include "test/benchmark/map/drive.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "test/benchmark/map/carmen_writer.hpp"
#include "test/support/planar_world.hpp"

namespace extperfc::benchmark {
namespace {

namespace fs = std::filesystem;

constexpr double kSpeedMPerS = 0.5;
constexpr double kYawRateRadPerS = 0.6;

struct Office {
  PlanarWorld world;
  std::vector<Eigen::Vector2d> route;
};

/// A corridor around a block, and rooms on all four outer sides.
class OfficeBuilder {
 public:
  Office build();

 private:
  using Point = Eigen::Vector2d;

  /// Rooms 5 m wide, with a door each, between the corridor's side `near` and the outer wall `far`.
  void add_rooms(double from, double to, double near, double far, bool along_x);
  void furnish(const Point& low, const Point& high);
  void add_alcoves();
  [[nodiscard]] static Point place(double along, double across, bool along_x) {
    return along_x ? Point(along, across) : Point(across, along);
  }

  Office office_;
  std::vector<Point> doors_;     // on the corridor's middle, in the order of the loop
  std::vector<Point> in_rooms_;  // behind each
  Rng rng_{7};
};

constexpr double kRoomM = 5.0;
constexpr double kDoorM = 1.1;
constexpr double kIntoRoomM = 2.3;  // from the corridor's middle

void OfficeBuilder::add_rooms(double from, double to, double near, double far, bool along_x) {
  const double middle = far > near ? near - 1.2 : near + 1.2;
  for (double start = from; start < to - 0.1; start += kRoomM) {
    const double door = start + rng_.uniform(1.2, 2.6);
    office_.world.add_wall(place(start, near, along_x), place(door, near, along_x));
    office_.world.add_wall(place(door + kDoorM, near, along_x), place(start + kRoomM, near, along_x));
    office_.world.add_wall(place(start, near, along_x), place(start, far, along_x));
    const double across = far > near ? 1.0 : -1.0;
    doors_.push_back(place(door + kDoorM / 2, middle, along_x));
    in_rooms_.push_back(place(door + kDoorM / 2, middle + across * kIntoRoomM, along_x));
    const double deep = near + across * 2.4;
    furnish(place(start + 0.2, std::min(deep, far), along_x),
            place(start + kRoomM - 0.2, std::max(deep, far), along_x));
  }
}

void OfficeBuilder::furnish(const Point& low, const Point& high) {
  for (int i = 0; i < 3; ++i) {
    const double width = rng_.uniform(0.4, 1.6);
    const double depth = rng_.uniform(0.4, 0.9);
    const double x = rng_.uniform(low.x(), std::max(low.x(), high.x() - width));
    const double y = rng_.uniform(low.y(), std::max(low.y(), high.y() - depth));
    office_.world.add_box(x, y, x + width, y + depth);
  }
}

/// Cupboards along the inner block, at uneven distances.
void OfficeBuilder::add_alcoves() {
  office_.world.add_box(9.2, 9.2, 36.8, 20.8);
  for (double x = 10; x < 35; x += rng_.uniform(3, 6)) {
    office_.world.add_box(x, 8.9, x + rng_.uniform(0.5, 1.4), 9.2);
    office_.world.add_box(x + 0.7, 20.8, x + 0.7 + rng_.uniform(0.5, 1.4), 21.1);
  }
}

Office OfficeBuilder::build() {
  office_.world.add_box(0, 0, 46, 30);
  add_alcoves();
  const std::vector<Point> corners{{8, 8}, {38, 8}, {38, 22}, {8, 22}};
  const auto round = [&](std::size_t first, bool backwards) {
    std::vector<std::size_t> order(doors_.size() - first);
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = first + i;
    if (backwards) std::reverse(order.begin(), order.end());
    for (const std::size_t i : order)
      office_.route.insert(office_.route.end(), {doors_[i], in_rooms_[i], doors_[i]});
  };
  const auto lap = [&] { office_.route.insert(office_.route.end(), corners.begin(), corners.end()); };
  lap();
  office_.route.push_back(corners[0]);
  add_rooms(8, 38, 6.8, 0, true);
  round(0, false);
  office_.route.push_back(corners[1]);
  std::size_t first = doors_.size();
  add_rooms(7.5, 22.5, 39.2, 46, false);
  round(first, false);
  office_.route.push_back(corners[2]);
  first = doors_.size();
  add_rooms(8, 38, 23.2, 30, true);
  round(first, true);
  office_.route.push_back(corners[3]);
  first = doors_.size();
  add_rooms(7.5, 22.5, 6.8, 0, false);
  round(first, true);
  lap();
  return std::move(office_);
}

/// Between scans a second apart, and between those that saw the same place at different times.
std::vector<offline::Relation> relations_of(const std::vector<Pose2>& poses, std::size_t second) {
  std::vector<offline::Relation> relations;
  const auto add = [&](std::size_t i, std::size_t j) {
    relations.push_back({i, j, between(poses[i], poses[j])});
  };
  constexpr double kSamePlaceM = 1.0;
  for (std::size_t i = 0; i + second < poses.size(); i += 2 * second) {
    add(i, i + second);
    for (std::size_t j = i + 30 * second; j < poses.size(); j += second)
      if (std::hypot(poses[i].x - poses[j].x, poses[i].y - poses[j].y) < kSamePlaceM) {
        add(i, j);
        break;
      }
  }
  return relations;
}

/// Pillars of a hall, and its outer walls, near a place: rays are cast against these alone.
class Hall {
 public:
  static constexpr double kSideM = 202;
  static constexpr double kLaneM = 20;
  static constexpr double kRangeM = 30;

  Hall() {
    constexpr double kSpacingM = 5;
    Rng rng(11);
    for (double x = 10; x < kSideM - 9; x += kSpacingM)  // the ends of the lanes stay free
      for (double y = 4; y < kSideM - 2; y += kSpacingM) {
        const Eigen::Vector2d low(x + rng.uniform(-1.5, 1.5), y + rng.uniform(-1.5, 1.5));
        const Eigen::Vector2d size(rng.uniform(0.3, 1.2), rng.uniform(0.3, 1.2));
        const double from_lane = std::abs(std::remainder(low.y() + size.y() / 2 - first_lane(), kLaneM));
        if (from_lane > 1.5) pillars_.push_back({low, low + size});
      }
  }

  [[nodiscard]] static double first_lane() { return 11; }

  [[nodiscard]] PlanarWorld near(const Pose2& pose) const {
    PlanarWorld world;
    world.add_box(0, 0, kSideM, kSideM);
    for (const auto& pillar : pillars_)
      if (std::hypot(pillar.low.x() - pose.x, pillar.low.y() - pose.y) < kRangeM + 2)
        world.add_box(pillar.low.x(), pillar.low.y(), pillar.high.x(), pillar.high.y());
    return world;
  }

 private:
  struct Pillar {
    Eigen::Vector2d low;
    Eigen::Vector2d high;
  };
  std::vector<Pillar> pillars_;
};

std::vector<Pose2> hall_drive() {
  std::vector<Eigen::Vector2d> corners;
  bool forward = true;
  for (double y = Hall::first_lane(); y < Hall::kSideM; y += Hall::kLaneM) {
    const double from = forward ? 6 : Hall::kSideM - 6;
    corners.insert(corners.end(), {{from, y}, {Hall::kSideM - from, y}});
    forward = !forward;
  }
  return planar_drive(corners, 1.0, 0.3);
}

}  // namespace

Result<void> write_relations(const std::vector<offline::Relation>& relations, const fs::path& file) {
  std::ofstream out(file);
  out.precision(9);
  for (const auto& [from, to, pose] : relations)
    out << from << ' ' << to << ' ' << pose.x << ' ' << pose.y << " 0 0 0 " << pose.yaw << '\n';
  out.close();
  if (out.fail()) return fail(ErrorCode::kFailed, "cannot write " + file.string());
  return {};
}

Result<Recording> record_office(const DriveParams& params, const fs::path& folder) {
  const Office office = OfficeBuilder().build();
  auto poses = planar_drive(office.route, kSpeedMPerS / params.rate_hz, kYawRateRadPerS / params.rate_hz);
  poses.resize(std::min(poses.size(), static_cast<std::size_t>(params.longest_s * params.rate_hz)));
  PlanarScanner scanner;
  scanner.rays = params.rays;
  scanner.angle_increment = 2 * M_PI / static_cast<double>(params.rays);
  Recording recording{folder / "office.log", folder / "office.relations"};
  CarmenWriter writer(recording.log);
  PlanarOdometry odometry;
  Rng rng(3);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i > 0) odometry.move(between(poses[i - 1], poses[i]), rng);
    writer.add(scanner.scan(office.world, poses[i], rng, static_cast<double>(i) / params.rate_hz),
               odometry.pose);
  }
  if (auto done = writer.finish(); !done) return tl::unexpected(done.error());
  const auto second = static_cast<std::size_t>(std::lround(params.rate_hz));
  const auto relations = relations_of(poses, std::max<std::size_t>(second, 1));
  if (auto done = write_relations(relations, recording.relations); !done) return tl::unexpected(done.error());
  return recording;
}

Result<Recording> record_hall(const fs::path& folder) {
  const Hall hall;
  const auto poses = hall_drive();
  PlanarScanner scanner;
  scanner.range_max = Hall::kRangeM;
  Recording recording{folder / "hall.log", {}};
  CarmenWriter writer(recording.log);
  PlanarOdometry odometry{0, 0, 0.001, 0.0005, 0.001, {}};
  Rng rng(5);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i > 0) odometry.move(between(poses[i - 1], poses[i]), rng);
    writer.add(scanner.scan(hall.near(poses[i]), poses[i], rng, static_cast<double>(i)), odometry.pose);
  }
  if (auto done = writer.finish(); !done) return tl::unexpected(done.error());
  return recording;
}

}  // namespace extperfc::benchmark
