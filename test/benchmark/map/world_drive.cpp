#include "test/benchmark/map/world_drive.hpp"

#include <algorithm>
#include <limits>

namespace extperfc::benchmark {
namespace {

using Point = Eigen::Vector2d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMaxScans = 30'000;
constexpr double kScanEveryS = 0.1;
constexpr double kFirstStampS = 100;
constexpr double kRangeMinM = 0.05;
constexpr double kRangeStepsPerM = 100;
constexpr double kThroughGlass = 0.75;  // fraction of the rays

constexpr double kPathStepM = 0.05;
constexpr double kSlopeM = 0.006;     // the wandering path leaves the straight line by this per step at most
constexpr double kStraightenM = 1.0;  // near corners it comes back to the line
constexpr double kLookAheadM = 0.5;
constexpr double kArrivedM = 0.3;
constexpr double kRotateOnSpotRad = 0.7;
constexpr double kSteerOverM = 0.35;  // the robot rotates towards its path within this distance

constexpr double kPedestrianRadiusM = 0.2;
constexpr double kNearestPedestrianM = 0.4;
constexpr double kFromWallM = 0.25;

Point position(const Pose2& pose) {
  return {pose.x, pose.y};
}

Point direction(double yaw_rad) {
  return {std::cos(yaw_rad), std::sin(yaw_rad)};
}

/// Points 5 cm apart along the route, off its lines by a distance that changes slowly.
std::vector<Point> wandering_path(const WorldCase& world, Rng& rng) {
  std::vector<Point> path;
  double offset = 0;
  double wanted = 0;
  double path_m = 0;
  double next_change = 0;
  for (std::size_t i = 1; i < world.route.size(); ++i) {
    const Point leg = world.route[i] - world.route[i - 1];
    const Point ahead = leg.normalized();
    const Point left(-ahead.y(), ahead.x());
    for (double along = 0; along < leg.norm(); along += kPathStepM, path_m += kPathStepM) {
      if (path_m > next_change) {
        wanted = rng.uniform(-world.wander_m, world.wander_m);
        next_change = path_m + rng.uniform(2, 8);
      }
      offset += std::clamp(wanted - offset, -kSlopeM, kSlopeM);
      const double to_corner = std::min(along, leg.norm() - along);
      path.push_back(world.route[i - 1] + ahead * along +
                     left * offset * std::min(1.0, to_corner / kStraightenM));
    }
  }
  path.push_back(world.route.back());
  return path;
}

/// A pose per scan of a robot that steers for a point half a metre ahead on its path.
std::vector<Pose2> follow(const std::vector<Point>& path, double step_m) {
  const double max_rotation = std::clamp(1.2 * step_m, 0.03, 0.15);
  const auto yaw_to = [](const Point& direction) { return std::atan2(direction.y(), direction.x()); };
  const std::size_t first = std::min<std::size_t>(10, path.size() - 1);
  Pose2 pose{path[0].x(), path[0].y(), yaw_to(path[first] - path[0])};
  std::vector<Pose2> poses{pose};
  std::size_t goal = 0;
  const auto is_last = [&] { return goal + 1 == path.size(); };
  while (poses.size() < kMaxScans && !(is_last() && (path[goal] - position(pose)).norm() <= kArrivedM)) {
    while (!is_last() && (path[goal] - position(pose)).norm() < kLookAheadM) ++goal;
    const double off = wrap_angle(yaw_to(path[goal] - position(pose)) - pose.yaw);
    if (std::abs(off) > kRotateOnSpotRad) {
      pose.yaw = wrap_angle(pose.yaw + std::clamp(off, -max_rotation, max_rotation));
    } else {
      pose.yaw = wrap_angle(pose.yaw + std::clamp(off * step_m / kSteerOverM, -max_rotation, max_rotation));
      pose.x += step_m * std::cos(pose.yaw);
      pose.y += step_m * std::sin(pose.yaw);
    }
    poses.push_back(pose);
  }
  return poses;
}

/// Wheel odometry of a step.
Pose2 measured(const Pose2& step, const WorldOdometry& odometry, Rng& rng) {
  const double distance_m = std::hypot(step.x, step.y);
  const double length = distance_m * (1 + odometry.scale) +
                        rng.normal(0, 1) * odometry.sigma_m_per_sqrt_m * std::sqrt(distance_m);
  const double sigma_rad = odometry.sigma_rad_per_sqrt_m * std::sqrt(distance_m) +
                           odometry.sigma_rad_per_sqrt_rad * std::sqrt(std::abs(step.yaw));
  const double rotation_rad = step.yaw * (1 + odometry.rotation_scale) +
                              odometry.veer_rad_per_m * distance_m + rng.normal(0, 1) * sigma_rad;
  const double stretch = distance_m > 1e-9 ? length / distance_m : 0.0;
  return {step.x * stretch, step.y * stretch, rotation_rad};
}

}  // namespace

Pedestrians::Pedestrian Pedestrians::appear(const WorldCase& world, const std::vector<Pose2>& poses,
                                            std::size_t now, Rng& rng) {
  Pedestrian pedestrian;
  pedestrian.left_m = rng.uniform(2, 12);
  const auto ahead = static_cast<std::size_t>(rng.uniform(2, 14) / world.step_m);
  const Pose2& place = poses[std::min(poses.size() - 1, now + ahead)];
  const Point aside = direction(rng.uniform(0, 2 * M_PI));
  pedestrian.at = position(place) + aside * rng.uniform(0.3, 0.7);
  const double yaw = place.yaw + (rng.chance(0.5) ? M_PI : 0.0);
  const Point heading = direction(yaw + rng.normal(0, 0.1));
  pedestrian.velocity = heading * rng.uniform(0, 3);
  if (!world.floor.is_floor(pedestrian.at, kFromWallM)) pedestrian.left_m = 0;
  return pedestrian;
}

void Pedestrians::move(const WorldCase& world, const std::vector<Pose2>& poses, std::size_t now, Rng& rng) {
  for (Pedestrian& pedestrian : all_) {
    pedestrian.left_m -= world.step_m;
    pedestrian.at += pedestrian.velocity * world.step_m;
    if (pedestrian.left_m <= 0 || !world.floor.is_floor(pedestrian.at, kFromWallM))
      pedestrian = appear(world, poses, now, rng);
  }
}

double Pedestrians::range(const Eigen::Vector2d& from, double angle_rad) const {
  const Point ray = direction(angle_rad);
  double nearest = kInfinity;
  for (const Pedestrian& pedestrian : all_) {
    if (pedestrian.left_m <= 0) continue;
    const Point to = pedestrian.at - from;
    const double along = to.dot(ray);
    const double across = to.y() * ray.x() - to.x() * ray.y();
    if (along <= kNearestPedestrianM || std::abs(across) >= kPedestrianRadiusM) continue;
    nearest = std::min(nearest, along - std::sqrt(kPedestrianRadiusM * kPedestrianRadiusM - across * across));
  }
  return nearest;
}

WorldRecorder::WorldRecorder(const WorldCase& world, std::uint64_t seed)
    : world_(world),
      rng_(seed * 7919 + 13),
      poses_(follow(wandering_path(world, rng_), world.step_m)),
      pedestrians_(world.pedestrians) {}

std::optional<WorldRecorder::Step> WorldRecorder::next() {
  if (now_ == poses_.size()) return std::nullopt;
  if (now_ > 0) drive_on();
  pedestrians_.move(world_, poses_, now_, rng_);
  Step step{scan(), odom_T_base_, poses_[now_], path_m_};
  ++now_;
  return step;
}

void WorldRecorder::drive_on() {
  const Pose2 step = between(poses_[now_ - 1], poses_[now_]);
  path_m_ += std::hypot(step.x, step.y);
  odom_T_base_ = compose(odom_T_base_, measured(step, world_.odometry, rng_));
}

LaserScan WorldRecorder::scan() {
  const WorldScanner& scanner = world_.scanner;
  LaserScan scan;
  scan.stamp_s = kFirstStampS + kScanEveryS * static_cast<double>(now_);
  scan.angle_min = scanner.angle_min;
  scan.angle_increment = scanner.angle_increment;
  scan.range_min = kRangeMinM;
  scan.range_max = scanner.range_max_m;
  scan.base_T_sensor = scanner.base_T_sensor;
  const Pose2 sensor = compose(poses_[now_], scanner.base_T_sensor);
  scan.ranges.reserve(static_cast<std::size_t>(scanner.rays));
  for (int ray = 0; ray < scanner.rays; ++ray)
    scan.ranges.push_back(range(sensor, sensor.yaw + scanner.angle_min + ray * scanner.angle_increment));
  return scan;
}

float WorldRecorder::range(const Pose2& sensor, double angle_rad) {
  const WorldScanner& scanner = world_.scanner;
  const auto hit = world_.floor.cast(position(sensor), angle_rad, scanner.range_max_m + 1);
  double range = hit.glass && rng_.chance(kThroughGlass) ? kInfinity : hit.range_m;
  range = std::min(range, pedestrians_.range(position(sensor), angle_rad));
  range += rng_.normal(0, scanner.sigma_m);
  if (scanner.outlier_fraction > 0 && rng_.chance(scanner.outlier_fraction))
    range = rng_.uniform(0.3, scanner.range_max_m);
  range = std::round(range * kRangeStepsPerM) / kRangeStepsPerM;
  return range <= scanner.range_max_m ? static_cast<float>(range) : std::numeric_limits<float>::infinity();
}

}  // namespace extperfc::benchmark
