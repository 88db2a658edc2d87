#pragma once

#include <memory>
#include <vector>

#include "extperfc/base/error.hpp"

#include "simulate/bodies/dynamic_limb.hpp"
#include "simulate/bodies/robot_body.hpp"
#include "simulate/bodies/scenery.hpp"

namespace extperfc::simulate {

/// A robot with a motor per joint and limited efforts. Its root follows commanded poses.
class DynamicRobot : public RobotBody {
 public:
  [[nodiscard]] static Result<std::unique_ptr<RobotBody>> make(PhysicsWorld& world, Scenery& scenery,
                                                               const RobotPlan& plan,
                                                               const Pose& world_T_root,
                                                               std::vector<double> start_positions);
  ~DynamicRobot() override;

  void before_step(const Pose& world_T_root) override;
  void after_step() override;
  void jump(const Pose& world_T_root) override;
  [[nodiscard]] double motor_effort(int joint) const override;
  [[nodiscard]] Pose world_T_group(int group) const override;
  double hold(int gripper, int body, double overlap_m) override;
  void release(int gripper) override;

 private:
  struct Place {
    int limb{-1};
    int link{-1};
  };
  struct Held {
    int body{-1};
    double finger_position{0};                    // where the driven finger stays
    std::unique_ptr<btMultiBodyConstraint> weld;  // none: nothing is held
  };

  DynamicRobot(PhysicsWorld& world, Scenery& scenery, const RobotPlan& plan, const Pose& world_T_root,
               std::vector<double> start_positions);
  [[nodiscard]] JointTarget target_with_mimic(int joint) const;
  /// The target of a finger that holds something: stay.
  [[nodiscard]] JointTarget target_with_grip(int joint) const;
  void carry_loads();
  void set_contacts(int gripper, int body, bool on);
  void move_free_joints();

  PhysicsWorld* world_;
  Scenery* scenery_;
  Pose world_T_root_;
  std::vector<std::unique_ptr<DynamicLimb>> limbs_;
  std::vector<Place> places_;  // by group
  std::vector<Held> held_;     // by gripper
};

}  // namespace extperfc::simulate
