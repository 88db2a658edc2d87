#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "extperfc/base/error.hpp"

#include "simulate/bodies/kinematic_body.hpp"
#include "simulate/bodies/robot_body.hpp"
#include "simulate/bodies/scenery.hpp"

namespace extperfc::simulate {

/// A robot whose joints follow their set points. Its links push loose bodies; what a gripper holds is carried
/// along, and stays behind only where something fixed blocks it.
class KinematicRobot : public RobotBody {
 public:
  [[nodiscard]] static Result<std::unique_ptr<RobotBody>> make(PhysicsWorld& world, Scenery& scenery,
                                                               const RobotPlan& plan,
                                                               const Pose& world_T_root,
                                                               std::vector<double> start_positions);

  void before_step(const Pose& world_T_root) override;
  void after_step() override;
  void jump(const Pose& world_T_root) override;
  [[nodiscard]] double motor_effort(int /*joint*/) const override { return 0; }
  [[nodiscard]] Pose world_T_group(int group) const override;
  double hold(int gripper, int body, double overlap_m) override;
  void release(int gripper) override;

 private:
  struct Held {
    int body{-1};
    double finger_position{0};  // where the driven finger stopped
    Pose hand_T_body{Pose::Identity()};
  };

  KinematicRobot(PhysicsWorld& world, Scenery& scenery, const RobotPlan& plan, const Pose& world_T_root,
                 std::vector<double> start_positions);
  [[nodiscard]] std::vector<double> next_positions() const;
  [[nodiscard]] double next_finger(int gripper) const;
  void carry(const std::vector<Pose>& root_T_link, const Pose& world_T_root);
  void set_contacts(int gripper, int body, bool on);

  PhysicsWorld* world_;
  Scenery* scenery_;
  Pose world_T_root_;
  std::vector<double> next_;
  std::vector<std::unique_ptr<KinematicBody>> links_;  // by group; none for the root's
  std::vector<std::optional<Held>> held_;              // by gripper
};

}  // namespace extperfc::simulate
