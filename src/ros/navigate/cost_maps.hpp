#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <ros/node_handle.h>
#include <tf2_ros/buffer.h>

#include "extperfc/navigate/cost_map.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/inflation_layer.hpp"
#include "extperfc/navigate/map_explanation.hpp"
#include "extperfc/navigate/moving_objects.hpp"
#include "extperfc/navigate/nav_error.hpp"
#include "extperfc/navigate/obstacle_layer.hpp"
#include "extperfc/navigate/static_layer.hpp"
#include "extperfc/navigate/zone_layer.hpp"
#include "extperfc/world/laser_scan.hpp"

#include "ros/health/stream_health.hpp"
#include "ros/navigate/cost_inbox.hpp"
#include "ros/navigate/placed_scan.hpp"
#include "ros/params/navigator_params.hpp"

namespace extperfc::ros_navigate {

/// The global cost map (in the map's frame) and the local one (a window around the robot in odom): fed from
/// the map, scans and clouds by a worker. Snapshots are shared and never change.
class CostMaps {
 public:
  using GridPtr = std::shared_ptr<const navigate::CostGrid>;
  /// Called by the worker.
  struct Callbacks {
    std::function<void(const PlacedScan&)> on_scan;    ///< before the maps know it, also one that they refuse
    std::function<void(const OccupancyGrid&)> on_map;  ///< after they know it
    std::function<std::vector<navigate::MovingObstacle>(double now_s)> people;   ///< in odom
    std::function<std::vector<navigate::MovingObstacle>(double now_s)> passers;  ///< in odom
  };

  CostMaps(const ros::NodeHandle& handle, const ros_params::NavigatorNodeParams& params, tf2_ros::Buffer& tf,
           Callbacks callbacks);
  ~CostMaps();
  CostMaps(const CostMaps&) = delete;
  CostMaps& operator=(const CostMaps&) = delete;

  /// Error: a zones file that cannot be read.
  [[nodiscard]] Result<void> start();
  void stop();

  [[nodiscard]] GridPtr local() const;
  [[nodiscard]] GridPtr global()
      const;  ///< null before the first map; copies what changed since the last call
  /// Why the robot must not drive by these maps.
  [[nodiscard]] std::optional<navigate::NavError> fault(const ros::Time& now) const;
  /// True once after another map came.
  [[nodiscard]] bool take_map_changed() { return map_changed_.exchange(false); }
  /// Factor of the speed zones [0, 1].
  [[nodiscard]] double speed_factor(const Pose2& map_T_base) const;

  /// Forgets what sensors saw farther than `beyond_m` from the robot (0: everything); what the latest scan
  /// saw is marked again at once.
  void clear(double beyond_m = 0);
  /// As clear(), and scans that wait are of another time.
  void forget();
  void set_footprint(const navigate::Footprint& footprint);
  void set_costs(const ros_params::CostMapParams& costs);
  void set_limits(const ros_params::DataLimits& limits);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status, double timeout_s);

 private:
  struct Layers {
    std::shared_ptr<navigate::StaticLayer> fixed;  ///< null in the local map
    std::shared_ptr<navigate::ObstacleLayer> obstacles;
    std::shared_ptr<navigate::InflationLayer> inflation;
    std::shared_ptr<navigate::ZoneLayer> zones;
    std::unique_ptr<navigate::CostMap> map;
  };

  void build_local();
  void build_global(const navigate::CostGrid& grid);
  void on_scan_message(const ros::MessageEvent<const sensor_msgs::LaserScan>& event, bool nearest);
  void work_off(const CostWork& work);
  void take_map(const nav_msgs::OccupancyGrid& message);
  void take_update(const map_msgs::OccupancyGridUpdate& message);
  [[nodiscard]] Result<void> take_scan(const sensor_msgs::LaserScan& message);
  void take_heights(const sensor_msgs::LaserScan& message, PlacedScan& placed);
  void keep_heights_of_map(PlacedScan& placed) const;
  void level_people(const PlacedScan& placed);
  void note_map_change();
  [[nodiscard]] Result<void> take_cloud(const sensor_msgs::PointCloud2& message);
  [[nodiscard]] Result<void> observe(const PlacedScan& placed);
  void observe_globally(const PlacedScan& placed, const Pose2& map_T_odom);
  [[nodiscard]] std::vector<navigate::MovingObstacle> passers(double now_s, const Pose2& map_T_odom) const;
  [[nodiscard]] Result<Pose> transform_at(const std::string& target, const std::string& source,
                                          const ros::Time& stamp) const;
  [[nodiscard]] navigate::Inflation inflation() const;
  [[nodiscard]] navigate::Inflation global_inflation(double resolution_m) const;
  [[nodiscard]] navigate::SensorParams sensor() const;

  static constexpr double kOldMapS = 6.0;  ///< age from which a map that grows shows what will stay

  ros::NodeHandle handle_;
  const std::string global_frame_;
  const std::string odom_frame_;
  const std::string base_frame_;
  tf2_ros::Buffer& tf_;
  const Callbacks callbacks_;
  CostInbox inbox_;
  ros_health::InputHealth scan_health_{"scan"};
  ros_health::WorkHealth work_health_;

  mutable std::mutex mutex_;  ///< guards what follows
  ros_params::CostMapParams costs_;
  ros_params::DataLimits limits_;
  navigate::Footprint footprint_;
  navigate::Zones zones_;
  navigate::MapHistory explanations_{kOldMapS};
  Layers local_;
  Layers global_;
  GridPtr local_snapshot_;
  mutable GridPtr global_snapshot_;  ///< null: older than the map
  std::optional<PlacedScan> last_scan_;
  ros::Time last_stamp_;  ///< of the newest scan
  std::string map_problem_;
  std::size_t maps_{0};          ///< and updates
  double map_changed_s_{0};      ///< stamp of the newest scan then
  std::string heights_problem_;  ///< why the latest scan's are not used; empty: nothing is wrong

  std::atomic<bool> map_changed_{false};
  std::atomic<bool> stopped_{false};
  ros::Subscriber nearest_subscriber_;
  ros::Subscriber scan_subscriber_;
  ros::Subscriber cloud_subscriber_;
  ros::Subscriber map_subscriber_;
  ros::Subscriber update_subscriber_;
  std::thread worker_;
};

}  // namespace extperfc::ros_navigate
