#include "ros/navigate/cost_maps.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include <ros/console.h>
#include <tf2_eigen/tf2_eigen.h>

#include "extperfc/base/stopwatch.hpp"

#include "ros/convert/laser_scan.hpp"
#include "ros/convert/occupancy_grid.hpp"
#include "ros/convert/scan.hpp"
#include "ros/navigate/plan_worker.hpp"

namespace extperfc::ros_navigate {

namespace {

using navigate::CostGrid;
using navigate::NavCode;
using navigate::NavError;

constexpr double kTransformWaitS = 0.1;  // of wall time
constexpr double kBlindM = 0.1;          // beyond the robot, where a scan may leave returns out as its own
constexpr double kSettledS = 60.0;       // without a change, a map counts as finished
constexpr float kHighestM = 10.0F;       // larger intensities cannot be heights

}  // namespace

CostMaps::CostMaps(const ros::NodeHandle& handle, const ros_params::NavigatorNodeParams& params,
                   tf2_ros::Buffer& tf, Callbacks callbacks)
    : handle_(handle),
      global_frame_(params.global_frame),
      odom_frame_(params.odom_frame),
      base_frame_(params.base_frame),
      tf_(tf),
      callbacks_(std::move(callbacks)),
      costs_(params.costs),
      limits_(params.limits),
      footprint_(params.footprint.padded()) {}

CostMaps::~CostMaps() {
  stop();
}

Result<void> CostMaps::start() {
  if (!costs_.zones_file.empty()) {
    auto zones = navigate::load_zones(costs_.zones_file);
    if (!zones) return tl::unexpected(zones.error());
    zones_ = std::move(*zones);
  }
  build_local();
  worker_ = std::thread([this] {
    while (const auto work = inbox_.take()) work_off(*work);
  });
  scan_health_.listening(true);
  using ScanEvent = ros::MessageEvent<const sensor_msgs::LaserScan>;
  nearest_subscriber_ = handle_.subscribe<sensor_msgs::LaserScan>(
      "scan_nearest", 2, boost::function<void(const ScanEvent&)>([this](const ScanEvent& event) {
        on_scan_message(event, true);
      }));
  scan_subscriber_ = handle_.subscribe<sensor_msgs::LaserScan>(
      "scan", 2, boost::function<void(const ScanEvent&)>([this](const ScanEvent& event) {
        on_scan_message(event, false);
      }));
  cloud_subscriber_ = handle_.subscribe<sensor_msgs::PointCloud2>(
      "obstacle_points", 1, [this](const auto& cloud) { inbox_.put_cloud(cloud); });
  map_subscriber_ =
      handle_.subscribe<nav_msgs::OccupancyGrid>("map", 1, [this](const auto& map) { inbox_.put_map(map); });
  update_subscriber_ = handle_.subscribe<map_msgs::OccupancyGridUpdate>(
      "map_updates", 50, [this](const auto& update) { inbox_.put_map_update(update); });
  return {};
}

void CostMaps::stop() {
  stopped_ = true;
  for (auto* subscriber :
       {&nearest_subscriber_, &scan_subscriber_, &cloud_subscriber_, &map_subscriber_, &update_subscriber_})
    subscriber->shutdown();
  inbox_.close();
  if (worker_.joinable()) worker_.join();
}

/// `scan` counts where no one publishes scan_nearest.
void CostMaps::on_scan_message(const ros::MessageEvent<const sensor_msgs::LaserScan>& event, bool nearest) {
  if (!nearest && nearest_subscriber_.getNumPublishers() > 0) return;
  const auto& scan = event.getConstMessage();
  scan_health_.received(scan->header.stamp, scan->ranges.data(), ros_health::came_by_pointer(event));
  inbox_.put_scan(scan);
}

navigate::Inflation CostMaps::inflation() const {
  const double inscribed_m = footprint_.inscribed_radius_m();
  return {inscribed_m, std::max(costs_.inflation_radius_m, inscribed_m), costs_.cost_scaling_factor};
}

/// Plans may be made with a smaller footprint: what it does not touch must not count as touched.
navigate::Inflation CostMaps::global_inflation(double resolution_m) const {
  navigate::Inflation inflation = this->inflation();
  inflation.inscribed_radius_m =
      std::max(0.0, inflation.inscribed_radius_m - kSmallestByCells * resolution_m);
  return inflation;
}

navigate::SensorParams CostMaps::sensor() const {
  navigate::SensorParams sensor;
  sensor.obstacle_range_m = costs_.obstacle_range_m;
  sensor.raytrace_range_m = costs_.raytrace_range_m;
  sensor.min_obstacle_height_m = costs_.min_obstacle_height_m;
  sensor.max_obstacle_height_m = costs_.max_obstacle_height_m;
  sensor.inf_is_valid = true;
  sensor.half_fov_rad = costs_.lidar_half_fov_rad;
  return sensor;
}

void CostMaps::build_local() {
  const int cells = static_cast<int>(std::lround(costs_.local_size_m / costs_.resolution_m));
  const double half_m = 0.5 * cells * costs_.resolution_m;
  navigate::ObstacleParams obstacles;
  obstacles.blind_m = footprint_.circumscribed_radius_m() + kBlindM;
  if (costs_.decay_s > 0) obstacles.unseen_decay_s = std::max(costs_.decay_s, obstacles.decay_s);
  local_.obstacles = std::make_shared<navigate::ObstacleLayer>(obstacles);
  local_.inflation = std::make_shared<navigate::InflationLayer>(inflation());
  local_.zones = std::make_shared<navigate::ZoneLayer>();
  local_.zones->set_zones(zones_);
  local_.map = std::make_unique<navigate::CostMap>(
      navigate::make_cost_grid(cells, cells, costs_.resolution_m, {-half_m, -half_m}, navigate::kFreeCost));
  local_.map->add(local_.obstacles);
  local_.map->add(local_.zones);
  local_.map->add(local_.inflation);
}

void CostMaps::build_global(const CostGrid& grid) {
  if (global_.map) {
    global_.inflation->set(global_inflation(grid.resolution_m));
    global_.map->resize(grid);
    return;
  }
  navigate::ObstacleParams obstacles;
  if (costs_.decay_s > 0) obstacles.unseen_decay_s = std::max(costs_.decay_s, obstacles.decay_s);
  obstacles.frees_unknown = true;
  global_.obstacles = std::make_shared<navigate::ObstacleLayer>(obstacles);
  global_.inflation = std::make_shared<navigate::InflationLayer>(global_inflation(grid.resolution_m));
  global_.zones = std::make_shared<navigate::ZoneLayer>();
  global_.zones->set_zones(zones_);
  global_.map = std::make_unique<navigate::CostMap>(grid);
  global_.map->add(global_.fixed);
  global_.map->add(global_.obstacles);
  global_.map->add(global_.zones);
  global_.map->add(global_.inflation);
}

void CostMaps::work_off(const CostWork& work) {
  Result<void> done;
  const Stopwatch watch;
  try {
    if (work.forget) clear();
    if (work.map) take_map(*work.map);
    for (const auto& update : work.map_updates) take_update(*update);
    if (work.cloud) done = take_cloud(*work.cloud);
    if (work.scan) {
      auto taken = take_scan(*work.scan);
      if (!taken) done = std::move(taken);
    }
  } catch (const std::exception& error) {
    done = fail(ErrorCode::kFailed, error.what());
  }
  if (!done && !stopped_ && work_health_.failed(done.error().message))
    ROS_ERROR("%s", done.error().message.c_str());
  if (done && work.scan) work_health_.done(watch.milliseconds(), ros_health::age_ms(work.scan->header.stamp));
}

void CostMaps::take_map(const nav_msgs::OccupancyGrid& message) {
  auto map = ros_convert::to_occupancy_grid(message);
  const std::lock_guard lock(mutex_);
  if (!map) {
    map_problem_ = map.error().message;
    ROS_ERROR("the map is refused: %s", map_problem_.c_str());
    return;
  }
  const bool unknown_is_free = !costs_.track_unknown;
  if (!global_.fixed)
    global_.fixed =
        std::make_shared<navigate::StaticLayer>(navigate::StaticParams{65, true, unknown_is_free});
  const auto grid =
      navigate::grid_around(*map, costs_.track_unknown ? navigate::kUnknownCost : navigate::kFreeCost);
  if (auto set = global_.fixed->set_map(std::move(*map)); !set) {
    map_problem_ = set.error().message;
    ROS_ERROR("the map is refused: %s", map_problem_.c_str());
    return;
  }
  map_problem_.clear();
  note_map_change();
  build_global(grid);
  (void)global_.map->update(last_stamp_.toSec());
  global_snapshot_.reset();
  explanations_.add(global_.fixed->map(), costs_.map_margin_m, last_stamp_.toSec());
  map_changed_ = true;
  callbacks_.on_map(global_.fixed->map());
}

void CostMaps::take_update(const map_msgs::OccupancyGridUpdate& message) {
  const std::lock_guard lock(mutex_);
  if (!global_.map) return;
  const navigate::CellBox box{
      {message.x, message.y},
      {message.x + static_cast<int>(message.width), message.y + static_cast<int>(message.height)}};
  if (auto taken = global_.fixed->update_map(box, {message.data.begin(), message.data.end()}); !taken) {
    ROS_ERROR("an update of the map is refused: %s", taken.error().message.c_str());
    return;
  }
  note_map_change();
  (void)global_.map->update(last_stamp_.toSec());
  global_snapshot_.reset();
  map_changed_ = true;
}

void CostMaps::note_map_change() {
  ++maps_;
  map_changed_s_ = last_stamp_.toSec();
}

Result<void> CostMaps::take_scan(const sensor_msgs::LaserScan& message) {
  const auto& stamp = message.header.stamp;
  const auto base_T_scanner = transform_at(base_frame_, message.header.frame_id, stamp);
  if (!base_T_scanner) return tl::unexpected(base_T_scanner.error());
  const auto odom_T_base = transform_at(odom_frame_, base_frame_, stamp);
  if (!odom_T_base) return tl::unexpected(odom_T_base.error());
  auto scan = ros_convert::to_laser_scan(message, *base_T_scanner);
  if (!scan) return tl::unexpected(scan.error());
  PlacedScan placed;
  placed.scan = std::move(*scan);
  placed.odom_T_base = to_pose2(*odom_T_base);
  placed.height_m = base_T_scanner->translation().z();
  take_heights(message, placed);
  const auto map_T_odom = transform_at(global_frame_, odom_frame_, ros::Time(0));
  if (map_T_odom) placed.map_T_odom = to_pose2(*map_T_odom);
  callbacks_.on_scan(placed);  // first: who comes into sight with this scan marks nothing
  const std::lock_guard lock(mutex_);
  keep_heights_of_map(placed);
  last_stamp_ = stamp;
  last_scan_ = placed;
  return observe(placed);
}

/// Heights of what the rays met, where the scan has them.
void CostMaps::take_heights(const sensor_msgs::LaserScan& message, PlacedScan& placed) {
  const std::lock_guard lock(mutex_);
  const std::string& lidar = costs_.lidar_frame;
  if (lidar.empty()) return;
  std::string problem;
  const bool as_many = message.intensities.size() == message.ranges.size();
  if (!as_many || std::any_of(message.intensities.begin(), message.intensities.end(),
                              [](float height_m) { return !(std::abs(height_m) < kHighestM); }))
    problem = "the scan's intensities are no heights: set intensity: height for cloud_to_scan";
  else if (!tf_.canTransform(base_frame_, lidar, ros::Time(0)))
    problem = "no transform from lidar_frame " + lidar + " to " + base_frame_;
  if (problem != heights_problem_ && !problem.empty())
    ROS_WARN("%s; what the lidar sees from afar only is forgotten near to it", problem.c_str());
  heights_problem_ = problem;
  if (!problem.empty()) return;
  const double own_m = placed.height_m;
  placed.height_m = tf_.lookupTransform(base_frame_, lidar, ros::Time(0)).transform.translation.z;
  placed.scan.heights_m = message.intensities;
  for (float& height_m : placed.scan.heights_m) height_m += static_cast<float>(own_m);
}

/// Heights count where a finished map shows an obstacle, too: it will not go away while the lidar is too near
/// to see it. A person who was seen from afar would leave a ghost, and a map that is made meanwhile shows
/// people: it counts where it has shown the obstacle for some time.
void CostMaps::keep_heights_of_map(PlacedScan& placed) const {
  LaserScan& scan = placed.scan;
  if (scan.heights_m.empty()) return;
  const bool finished = maps_ == 1 || scan.stamp_s - map_changed_s_ > kSettledS;
  const auto old_s = explanations_.old_stamp_s();
  const bool has_old = old_s && scan.stamp_s - *old_s > kOldMapS;
  if (!placed.map_T_odom || !(finished || has_old)) return scan.heights_m.clear();
  const Pose2 map_T_base = compose(*placed.map_T_odom, placed.odom_T_base);
  const Pose2 map_T_sensor = compose(map_T_base, scan.base_T_sensor);
  const auto news = explanations_.newest().unexplained(scan, map_T_sensor);
  const auto change = finished ? news : explanations_.old().unexplained(scan, map_T_sensor);
  for (std::size_t i = 0; i < scan.heights_m.size(); ++i)
    if (is_return(scan, news.ranges[i]) || is_return(scan, change.ranges[i]))
      scan.heights_m[i] = static_cast<float>(placed.height_m);
}

/// Who walks through a door is so near to its frame that the map explains them: their marks shall go with
/// them, those from before they were known, too.
void CostMaps::level_people(const PlacedScan& placed) {
  constexpr double kAroundM = 0.25;
  if (placed.scan.heights_m.empty()) return;
  for (const auto& person : callbacks_.people(placed.scan.stamp_s))
    local_.obstacles->level(person.position_m, person.radius_m + kAroundM, placed.height_m);
}

Result<void> CostMaps::observe(const PlacedScan& placed) {
  const Pose2 odom_T_sensor = compose(placed.odom_T_base, placed.scan.base_T_sensor);
  local_.map->centre_on({placed.odom_T_base.x, placed.odom_T_base.y});
  if (auto seen = local_.obstacles->observe(placed.scan, odom_T_sensor, placed.height_m, sensor()); !seen)
    return seen;
  level_people(placed);
  local_.obstacles->clear_footprint(footprint_, placed.odom_T_base);
  if (placed.map_T_odom) local_.zones->set_pose(inverse(*placed.map_T_odom));
  (void)local_.map->update(placed.scan.stamp_s);
  local_snapshot_ = std::make_shared<const CostGrid>(local_.map->grid());
  if (global_.map && placed.map_T_odom) observe_globally(placed, *placed.map_T_odom);
  return {};
}

/// In the map's frame.
std::vector<navigate::MovingObstacle> CostMaps::passers(double now_s, const Pose2& map_T_odom) const {
  auto people = callbacks_.passers(now_s);
  for (auto& person : people) {
    const Pose2 place = compose(map_T_odom, {person.position_m.x(), person.position_m.y(), 0});
    person.position_m = {place.x, place.y};
  }
  return people;
}

/// Every ray clears; what the map does not explain marks, but for people who pass: a plan around them is
/// late.
void CostMaps::observe_globally(const PlacedScan& placed, const Pose2& map_T_odom) {
  const Pose2 map_T_base = compose(map_T_odom, placed.odom_T_base);
  const Pose2 map_T_sensor = compose(map_T_base, placed.scan.base_T_sensor);
  auto clears = sensor();
  clears.marks = false;
  auto marks = sensor();
  marks.clears = false;
  (void)global_.obstacles->observe(placed.scan, map_T_sensor, placed.height_m, clears);
  const auto rest = navigate::without(explanations_.newest().unexplained(placed.scan, map_T_sensor),
                                      passers(placed.scan.stamp_s, map_T_odom), map_T_sensor);
  (void)global_.obstacles->observe(rest, map_T_sensor, placed.height_m, marks);
  global_.obstacles->clear_footprint(footprint_, map_T_base);
  if (!global_.map->update(placed.scan.stamp_s).empty()) global_snapshot_.reset();
}

Result<void> CostMaps::take_cloud(const sensor_msgs::PointCloud2& message) {
  const auto view = ros_convert::to_cloud_view(message);
  if (!view) return fail(view.error().code, cloud_subscriber_.getTopic() + ": " + view.error().message);
  auto points = scan::points_of(*view);
  if (!points) return fail(points.error().code, cloud_subscriber_.getTopic() + ": " + points.error().message);
  const auto odom_T_sensor = transform_at(odom_frame_, message.header.frame_id, message.header.stamp);
  if (!odom_T_sensor) return tl::unexpected(odom_T_sensor.error());
  const auto map_T_odom = transform_at(global_frame_, odom_frame_, ros::Time(0));
  navigate::PointObservation cloud;
  cloud.stamp_s = message.header.stamp.toSec();
  cloud.sensor_m = odom_T_sensor->translation();
  const Eigen::Isometry3f transform = odom_T_sensor->cast<float>();
  cloud.points_m = std::move(*points);
  for (auto& point : cloud.points_m) point = transform * point;
  const std::lock_guard lock(mutex_);
  if (auto seen = local_.obstacles->observe(cloud, sensor()); !seen) return seen;
  if (!global_.map || !map_T_odom) return {};
  const Pose& map_T_sensor = *map_T_odom;
  cloud.sensor_m = map_T_sensor * cloud.sensor_m;
  for (auto& point : cloud.points_m) point = map_T_sensor.cast<float>() * point;
  cloud.points_m =
      navigate::without(std::move(cloud.points_m), passers(cloud.stamp_s, to_pose2(*map_T_odom)));
  return global_.obstacles->observe(cloud, sensor());
}

/// Polls in wall time: tf2's own wait would not end while simulated time stands still.
Result<Pose> CostMaps::transform_at(const std::string& target, const std::string& source,
                                    const ros::Time& stamp) const {
  if (target == source) return Pose::Identity();
  const auto deadline = ros::WallTime::now() + ros::WallDuration(kTransformWaitS);
  while (!tf_.canTransform(target, source, stamp) && !stopped_ && ros::WallTime::now() < deadline)
    ros::WallDuration(0.002).sleep();
  try {
    const Pose found = tf2::transformToEigen(tf_.lookupTransform(target, source, stamp));
    if (found.matrix().allFinite()) return found;
  } catch (const tf2::TransformException&) {
    return fail(ErrorCode::kNotFound, "no transform from " + source + " to " + target +
                                          " at the stamp of the data; check that tf is published");
  }
  return fail(ErrorCode::kCorrupt, "the transform from " + source + " to " + target + " is not finite");
}

CostMaps::GridPtr CostMaps::local() const {
  const std::lock_guard lock(mutex_);
  return local_snapshot_;
}

CostMaps::GridPtr CostMaps::global() const {
  const std::lock_guard lock(mutex_);
  if (!global_snapshot_ && global_.map)
    global_snapshot_ = std::make_shared<const CostGrid>(global_.map->grid());
  return global_snapshot_;
}

std::optional<NavError> CostMaps::fault(const ros::Time& now) const {
  const std::lock_guard lock(mutex_);
  if (!global_.map)
    return NavError{NavCode::kNoMap,
                    map_problem_.empty() ? "no map on " + handle_.resolveName("map") : map_problem_};
  const double age_s = now.toSec() - last_stamp_.toSec();
  if (!local_snapshot_ || last_stamp_.isZero())
    return NavError{NavCode::kNoScan, "no scan on " + handle_.resolveName("scan_nearest") + " or " +
                                          handle_.resolveName("scan")};
  if (std::abs(age_s) <= limits_.scan_s) return std::nullopt;
  char text[64];
  (void)std::snprintf(text, sizeof(text), "the newest scan is %.2f s old", age_s);
  return NavError{NavCode::kNoScan, text};
}

double CostMaps::speed_factor(const Pose2& map_T_base) const {
  const std::lock_guard lock(mutex_);
  return global_.zones ? global_.zones->speed_factor_at({map_T_base.x, map_T_base.y}) : 1.0;
}

void CostMaps::clear(double beyond_m) {
  const std::lock_guard lock(mutex_);
  if (beyond_m > 0 && last_scan_) {
    const Pose2& odom_T_base = last_scan_->odom_T_base;
    local_.obstacles->clear_beyond({odom_T_base.x, odom_T_base.y}, beyond_m);
    if (global_.map && last_scan_->map_T_odom) {
      const Pose2 map_T_base = compose(*last_scan_->map_T_odom, odom_T_base);
      global_.obstacles->clear_beyond({map_T_base.x, map_T_base.y}, beyond_m);
    }
  } else {
    local_.map->clear();
    if (global_.map) global_.map->clear();
  }
  if (last_scan_) (void)observe(*last_scan_);  // it was taken before
}

void CostMaps::forget() {
  {
    const std::lock_guard lock(mutex_);
    last_scan_.reset();
    last_stamp_ = ros::Time();
  }
  inbox_.put_forget();
}

void CostMaps::set_footprint(const navigate::Footprint& footprint) {
  const std::lock_guard lock(mutex_);
  footprint_ = footprint;
  if (local_.inflation) local_.inflation->set(inflation());
  if (global_.inflation) global_.inflation->set(global_inflation(global_.map->grid().resolution_m));
}

void CostMaps::set_costs(const ros_params::CostMapParams& costs) {
  const std::lock_guard lock(mutex_);
  costs_ = costs;
  if (local_.inflation) local_.inflation->set(inflation());
  if (global_.inflation) global_.inflation->set(global_inflation(global_.map->grid().resolution_m));
}

void CostMaps::set_limits(const ros_params::DataLimits& limits) {
  const std::lock_guard lock(mutex_);
  limits_ = limits;
}

void CostMaps::report(diagnostic_updater::DiagnosticStatusWrapper& status, double timeout_s) {
  using diagnostic_msgs::DiagnosticStatus;
  status.summary(DiagnosticStatus::OK, "running");
  status.add("dropped", inbox_.dropped());
  scan_health_.report(status,
                      nearest_subscriber_.getNumPublishers() > 0 ? nearest_subscriber_.getTopic()
                                                                 : scan_subscriber_.getTopic(),
                      timeout_s);
  work_health_.report(status);
  const std::lock_guard lock(mutex_);
  const std::string heights = costs_.lidar_frame.empty() ? "none" : "where a finished map shows an obstacle";
  status.add("heights of scans", heights_problem_.empty() ? heights : heights_problem_);
  status.add("obstacle cells", local_.obstacles ? local_.obstacles->marked_cells() : 0);
  if (!global_.map)
    status.mergeSummary(DiagnosticStatus::WARN, map_problem_.empty() ? "no map yet" : map_problem_);
}

}  // namespace extperfc::ros_navigate
