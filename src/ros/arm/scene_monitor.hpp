#pragma once

#include <functional>
#include <optional>
#include <string>

#include <ros/time.h>
#include <std_msgs/Header.h>

#include "extperfc/arm/robot_arms.hpp"

#include "ros/arm/planning_scene.hpp"
#include "ros/arm/transform_lookup.hpp"

namespace extperfc::ros_arm {

/// What the monitors use that add observations to the planning scene.
struct SceneMonitorContext {
  const arm::RobotArms& arms;
  const TransformLookup& transforms;
  PlanningScene& scene;
  std::string world_frame;
  std::function<void()> changed;  ///< called when a monitor increased the scene's version
};

/// Where the robot is in the frame that stands still while the base drives. Not thread-safe.
class WorldFrame {
 public:
  /// Keeps the reference.
  WorldFrame(const TransformLookup& transforms, std::string name)
      : transforms_(transforms), name_(std::move(name)) {}

  /// world_T_root; std::nullopt where tf lacks the frame, which is looked up again after 5 s of wall time.
  /// Error: tf has the frame, but not at this stamp.
  [[nodiscard]] Result<std::optional<Pose>> world_T_root(const ros::Time& stamp);

 private:
  const TransformLookup& transforms_;
  const std::string name_;
  ros::WallTime missing_since_;  ///< last failed lookup; zero after a successful one
};

/// root_T_frame of a message. Errors: no frame_id or no stamp, which the message on `topic` must have; no
/// transform.
[[nodiscard]] Result<Pose> root_T_header(const TransformLookup& transforms, const std_msgs::Header& header,
                                         const char* topic);

}  // namespace extperfc::ros_arm
