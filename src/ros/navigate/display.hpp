#pragma once

#include <memory>
#include <string>
#include <vector>

#include <map_msgs/OccupancyGridUpdate.h>
#include <ros/node_handle.h>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/local_planner.hpp"
#include "extperfc/navigate/path.hpp"

namespace extperfc::ros_navigate {

/// A cost map as costmap_2d publishes it: 0 free, 1 to 98 costs, 99 inscribed, 100 lethal, -1 unknown. The
/// whole map to each new subscriber and after it was resized or moved; else the rectangle that changed. One
/// thread at a time.
class CostMapPublisher {
 public:
  using GridPtr = std::shared_ptr<const navigate::CostGrid>;

  CostMapPublisher(ros::NodeHandle handle, const std::string& topic, std::string frame);
  void publish(const GridPtr& grid, const ros::Time& stamp);
  /// Whether it has subscribers, or was never published.
  [[nodiscard]] bool wanted() const { return !grid_ || whole_.getNumSubscribers() > 0; }

 private:
  void publish_whole(const ros::Time& stamp);
  void publish_changes(const navigate::CostGrid& before, const ros::Time& stamp);

  const std::string frame_;
  GridPtr grid_;  ///< published last
  unsigned subscribers_{0};
  ros::Publisher whole_;
  ros::Publisher changes_;
};

/// What rviz shows of the navigator: paths, footprint, candidate trajectories, people. One thread at a time.
class Display {
 public:
  Display(ros::NodeHandle handle, std::string global_frame, std::string odom_frame);

  [[nodiscard]] bool wants_candidates() const { return candidates_.getNumSubscribers() > 0; }
  void global_plan(const navigate::Path& path, const ros::Time& stamp);
  void local_plan(const std::vector<Pose2>& trajectory, const ros::Time& stamp);
  void candidates(const std::vector<std::vector<Pose2>>& trajectories, const ros::Time& stamp);
  void footprint(const navigate::Footprint& footprint, const Pose2& odom_T_base, const ros::Time& stamp);
  void people(const std::vector<navigate::MovingObstacle>& people, const ros::Time& stamp);
  void goal(const Pose2& goal, const ros::Time& stamp);

 private:
  const std::string global_frame_;
  const std::string odom_frame_;
  ros::Publisher global_plan_;
  ros::Publisher local_plan_;
  ros::Publisher candidates_;
  ros::Publisher footprint_;
  ros::Publisher people_;
  ros::Publisher goal_;
};

}  // namespace extperfc::ros_navigate
