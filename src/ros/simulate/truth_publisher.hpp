#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <ros/node_handle.h>

#include "extperfc/simulate/simulator.hpp"

#include "ros/params/simulator_params.hpp"
#include "ros/simulate/sim_host.hpp"
#include "ros/simulate/ticker.hpp"
#include "ros/simulate/truth_classes.hpp"
#include "ros/simulate/world_markers.hpp"

namespace extperfc::ros_simulate {

/// The ground truth, for evaluation and for people; a robot does not publish it.
///
/// Publishes (in the frame map):
///   sim/truth/odom         nav_msgs/Odometry: where the robot is, map -> base_footprint
///   sim/truth/objects      vision_msgs/Detection3DArray of the bodies that have a class and of the people:
///                          results[0].id is the class; bbox encloses the body and has its axes;
///                          results[0].pose is bbox.center, as with box_depth: a cone's centre of mass lies a
///                          quarter of its height lower
///   sim/truth/blocked      std_msgs/Bool, latched, at changes: the base stands against something
///   sim/truth/map          nav_msgs/OccupancyGrid, latched: the floor plan at the start
///   sim/truth/vision_info  vision_msgs/VisionInfo, latched: where the class names are
///   sim/world_markers      visualization_msgs/MarkerArray: everything to each new subscriber, then what
///                          moves
class TruthPublisher {
 public:
  TruthPublisher(ros::NodeHandle handle, const ros::NodeHandle& private_handle, SimHost& host,
                 const ros_params::TruthParams& params, const simulate::WorldSpec& world,
                 const TruthClasses& classes);

  /// Error: the map cannot be made.
  [[nodiscard]] Result<void> publish_map(const simulate::WorldSpec& world,
                                         const ros_params::TruthParams& params);

 private:
  /// Something with a class.
  struct Object {
    std::size_t index;  ///< into the snapshot's bodies or people
    bool is_person;
    int class_id;
    Eigen::AlignedBox3d extent;  ///< in its own frame
  };

  void find_objects(const simulate::WorldSpec& world, const TruthClasses& classes);
  void publish_vision_info(const ros::NodeHandle& private_handle);
  void advertise_markers(ros::NodeHandle& handle);
  void after_step(const simulate::Simulator& simulator, const ros::Time& stamp);
  void publish_odometry(const simulate::BaseState& base, const ros::Time& stamp);
  void publish_blocked(bool blocked);
  void publish_objects(const simulate::Snapshot& snapshot, const ros::Time& stamp);

  SimHost& host_;
  std::vector<Object> objects_;
  WorldMarkers markers_;
  Ticker odom_ticker_;
  Ticker objects_ticker_;
  Ticker markers_ticker_;
  ros::Time stamp_{ros::Time(1.0)};  ///< of the last step; simulation thread
  std::optional<bool> blocked_;      ///< published last; simulation thread
  ros::Publisher odom_publisher_;
  ros::Publisher blocked_publisher_;
  ros::Publisher objects_publisher_;
  ros::Publisher map_publisher_;
  ros::Publisher vision_info_publisher_;
  ros::Publisher markers_publisher_;
};

}  // namespace extperfc::ros_simulate
