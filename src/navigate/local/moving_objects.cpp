#include "extperfc/navigate/moving_objects.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "extperfc/base/demand.hpp"
#include "extperfc/base/math.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kPersonMarginM = 0.15;
constexpr double kOwnM = 0.4;    // returns of a pedestrian are nearer to where they should be
constexpr double kApartM = 0.4;  // between two people side by side; tracks that are nearer are one's legs

/// The smallest circle's stand-in: about the middle of the box around the points.
struct Extent {
  Eigen::Vector2d middle_m{0, 0};
  double radius_m{0};
};

Extent extent_of(const std::vector<Eigen::Vector2d>& points_m) {
  Eigen::Vector2d low = points_m.front();
  Eigen::Vector2d high = points_m.front();
  for (const Eigen::Vector2d& point : points_m) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  Extent extent{(low + high) / 2, 0};
  for (const Eigen::Vector2d& point : points_m)
    extent.radius_m = std::max(extent.radius_m, (point - extent.middle_m).norm());
  return extent;
}

bool is_person(const Eigen::Vector2d& point_m, const std::vector<MovingObstacle>& people) {
  return std::any_of(people.begin(), people.end(), [&point_m](const MovingObstacle& person) {
    return (point_m - person.position_m).norm() <= person.radius_m + kPersonMarginM;
  });
}

/// Whose return a point is: the nearest pedestrian.
std::optional<std::size_t> owner_of(const Eigen::Vector2d& point_m,
                                    const std::vector<MovingObstacle>& pedestrians) {
  std::optional<std::size_t> owner;
  double nearest_m = kOwnM;
  for (std::size_t i = 0; i < pedestrians.size(); ++i) {
    const double away_m = (point_m - pedestrians[i].position_m).norm();
    if (away_m >= nearest_m) continue;
    nearest_m = away_m;
    owner = i;
  }
  return owner;
}

/// Whether one of two points is a return of a pedestrian, and the other is not, or of another one. One who
/// has two tracks is one.
bool are_of_two(const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m,
                const std::vector<MovingObstacle>& pedestrians) {
  const auto a = owner_of(a_m, pedestrians);
  const auto b = owner_of(b_m, pedestrians);
  if (a == b) return false;
  return !a || !b || (pedestrians[*a].position_m - pedestrians[*b].position_m).norm() >= kApartM;
}

Eigen::Vector2d point_of(const LaserScan& scan, std::size_t ray, const Pose2& map_T_sensor) {
  const double range_m = scan.ranges[ray];
  const double angle = map_T_sensor.yaw + scan.angle_min + static_cast<double>(ray) * scan.angle_increment;
  return {map_T_sensor.x + range_m * std::cos(angle), map_T_sensor.y + range_m * std::sin(angle)};
}

std::optional<double> range_of(const LaserScan& scan, std::size_t ray, double max_range_m) {
  const float range_m = scan.ranges[ray];
  if (!is_return(scan, range_m) || range_m > max_range_m) return std::nullopt;
  return range_m;
}

}  // namespace

struct MovingObjectDetector::Cluster {
  std::vector<Eigen::Vector2d> points_m;
  int explained{0};
  std::size_t first_ray{0};
  std::size_t last_ray{0};
};

MovingObjectDetector::MovingObjectDetector(const MovingObjectParams& params)
    : params_(params), maps_(params.old_map_s) {
  demand(params.gap_m > 0 && params.gap_m <= 1, "gap_m must be above 0 and at most 1");
  demand(params.join_m >= 0 && params.join_m <= 2, "join_m must be from 0 to 2");
  demand(params.max_radius_m <= 2, "max_radius_m must be at most 2");
  demand(params.min_radius_m > 0 && params.min_radius_m <= params.max_radius_m,
         "min_radius_m must be above 0 and at most max_radius_m");
  demand(params.map_margin_m >= 0 && params.map_margin_m <= 2, "map_margin_m must be from 0 to 2");
  demand(params.max_explained >= 0 && params.max_explained <= 1, "max_explained must be from 0 to 1");
  demand(params.min_returns >= 1, "min_returns must be 1 or more");
  demand(params.max_range_m > 0, "max_range_m must be above 0");
  demand(params.old_map_s >= 0, "old_map_s must be 0 or more");
}

void MovingObjectDetector::set_map(const OccupancyGrid& map, double stamp_s) {
  maps_.add(map, params_.map_margin_m, stamp_s);
}

/// A map that is made meanwhile soon shows who walks, too, and would explain them.
bool MovingObjectDetector::is_explained(const Eigen::Vector2d& point_m,
                                        const std::vector<MovingObstacle>& pedestrians) const {
  return maps_.newest().explains(point_m, 0) &&
         (!is_person(point_m, pedestrians) || maps_.old().explains(point_m, 0));
}

std::vector<MovingObjectDetector::Cluster> MovingObjectDetector::clusters(
    const LaserScan& scan, const Pose2& map_T_base, const std::vector<MovingObstacle>& pedestrians) const {
  std::vector<Cluster> result;
  const Pose2 map_T_sensor = compose(map_T_base, scan.base_T_sensor);
  const double between_rays = 2 * std::abs(scan.angle_increment);
  double before_m = 0;
  for (std::size_t ray = 0; ray < scan.ranges.size(); ++ray) {
    const auto range_m = range_of(scan, ray, params_.max_range_m);
    if (!range_m) continue;
    const Eigen::Vector2d point = point_of(scan, ray, map_T_sensor);
    const double gap_m = std::max(params_.gap_m, between_rays * std::min(*range_m, before_m));
    const bool same = !result.empty() && ray <= result.back().last_ray + 2 &&
                      (point - result.back().points_m.back()).norm() <= gap_m &&
                      !are_of_two(point, result.back().points_m.back(), pedestrians);
    if (!same) result.push_back({{}, 0, ray, ray});
    Cluster& cluster = result.back();
    cluster.points_m.push_back(point);
    cluster.last_ray = ray;
    if (is_explained(point, pedestrians)) ++cluster.explained;
    before_m = *range_m;
  }
  // A sweep of a full revolution begins where it ends.
  const double sweep = std::abs(scan.angle_increment) * static_cast<double>(scan.ranges.size());
  const bool closed = result.size() > 1 && sweep > kTwoPi - between_rays && result.front().first_ray < 2 &&
                      result.back().last_ray + 2 >= scan.ranges.size();
  if (closed && (result.front().points_m.front() - result.back().points_m.back()).norm() <= params_.gap_m &&
      !are_of_two(result.front().points_m.front(), result.back().points_m.back(), pedestrians)) {
    Cluster& first = result.front();
    Cluster& last = result.back();
    first.points_m.insert(first.points_m.end(), last.points_m.begin(), last.points_m.end());
    first.explained += last.explained;
    result.pop_back();
  }
  return result;
}

/// Two legs are one person: clusters are joined, the nearest ones first, while their union has a person's
/// size; what belongs to a known pedestrian with nothing else.
void MovingObjectDetector::join(std::vector<Cluster>& clusters,
                                const std::vector<MovingObstacle>& pedestrians) const {
  while (const auto pair = nearest_pair(clusters, pedestrians)) {
    Cluster& into = clusters[pair->first];
    const Cluster& from = clusters[pair->second];
    into.points_m.insert(into.points_m.end(), from.points_m.begin(), from.points_m.end());
    into.explained += from.explained;
    clusters.erase(clusters.begin() + static_cast<std::ptrdiff_t>(pair->second));
  }
}

/// The two clusters to join next, the first of them before the second.
std::optional<std::pair<std::size_t, std::size_t>> MovingObjectDetector::nearest_pair(
    const std::vector<Cluster>& clusters, const std::vector<MovingObstacle>& pedestrians) const {
  std::vector<Eigen::Vector2d> middles_m;
  middles_m.reserve(clusters.size());
  for (const Cluster& cluster : clusters) middles_m.push_back(extent_of(cluster.points_m).middle_m);
  std::optional<std::pair<std::size_t, std::size_t>> pair;
  double nearest_m = params_.join_m;
  for (std::size_t i = 0; i < clusters.size(); ++i)
    for (std::size_t j = i + 1; j < clusters.size(); ++j) {
      const double apart_m = (middles_m[i] - middles_m[j]).norm();
      if (apart_m > nearest_m || are_of_two(middles_m[i], middles_m[j], pedestrians)) continue;
      std::vector<Eigen::Vector2d> both = clusters[i].points_m;
      both.insert(both.end(), clusters[j].points_m.begin(), clusters[j].points_m.end());
      if (extent_of(both).radius_m > params_.max_radius_m) continue;
      nearest_m = apart_m;
      pair.emplace(i, j);
    }
  return pair;
}

std::vector<MovingCandidate> MovingObjectDetector::detect(
    const LaserScan& scan, const Pose2& map_T_base, const std::vector<MovingObstacle>& pedestrians) const {
  std::vector<Cluster> found = clusters(scan, map_T_base, pedestrians);
  const auto is_other = [this](const Cluster& cluster) {
    const auto returns = static_cast<double>(cluster.points_m.size());
    return cluster.explained > params_.max_explained * returns ||
           extent_of(cluster.points_m).radius_m > params_.max_radius_m;
  };
  found.erase(std::remove_if(found.begin(), found.end(), is_other), found.end());
  join(found, pedestrians);
  std::vector<MovingCandidate> candidates;
  candidates.reserve(found.size());
  for (const Cluster& cluster : found) {
    const auto returns = static_cast<int>(cluster.points_m.size());
    if (returns < params_.min_returns) continue;
    const Extent extent = extent_of(cluster.points_m);
    candidates.push_back({extent.middle_m, std::max(params_.min_radius_m, extent.radius_m), returns});
  }
  return candidates;
}

LaserScan without(LaserScan scan, const std::vector<MovingObstacle>& people, const Pose2& map_T_sensor) {
  std::vector<Disc> discs;
  discs.reserve(people.size());
  for (const MovingObstacle& person : people)
    discs.push_back({person.position_m, person.radius_m + kPersonMarginM});
  return without_discs(std::move(scan), discs, map_T_sensor);
}

std::vector<Eigen::Vector3f> without(std::vector<Eigen::Vector3f> points_m,
                                     const std::vector<MovingObstacle>& people) {
  const auto is_one = [&people](const Eigen::Vector3f& point_m) {
    return is_person(point_m.head<2>().cast<double>(), people);
  };
  if (!people.empty())
    points_m.erase(std::remove_if(points_m.begin(), points_m.end(), is_one), points_m.end());
  return points_m;
}

}  // namespace extperfc::navigate
