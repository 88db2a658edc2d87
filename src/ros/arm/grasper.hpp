#pragma once

#include <memory>
#include <string>
#include <vector>

#include <extperfc/PickAction.h>
#include <extperfc/PlaceAction.h>

#include "extperfc/arm/pick_and_place.hpp"

#include "ros/arm/gripper.hpp"
#include "ros/arm/plan_execution.hpp"

namespace extperfc::ros_arm {

/// Picks up objects of the scene and places them. Not thread-safe: the caller holds the lease of the arms.
class Grasper {
 public:
  /// Errors: a gripper that the robot does not have, see arm::hand_of(). Keeps the reference to `execution`.
  [[nodiscard]] static Result<std::unique_ptr<Grasper>> make(const ros::NodeHandle& handle,
                                                             PlanExecution& execution);

  [[nodiscard]] Status pick(const extperfc::PickGoal& goal, const MotionCallbacks& callbacks,
                            extperfc::PickResult& result);
  [[nodiscard]] Status place(const extperfc::PlaceGoal& goal, const MotionCallbacks& callbacks,
                             extperfc::PlaceResult& result);

 private:
  struct Hand {
    arm::Manipulator manipulator;
    std::unique_ptr<Gripper> gripper;
    std::vector<arm::JointVector> place;  ///< posture found for place_at of the pick; empty if unknown

    [[nodiscard]] const std::string& tip() const { return manipulator.hand.tip_link; }
  };
  template <typename T>
  using Maybe = tl::expected<T, Status>;

  Grasper(PlanExecution& execution, std::vector<Hand> hands)
      : execution_(execution), hands_(std::move(hands)) {}

  // Pick.
  [[nodiscard]] Maybe<arm::PickTask> pick_task(const extperfc::PickGoal& goal,
                                               const MotionCallbacks& callbacks) const;
  /// The arms whose grippers are empty; `arm`: this one only, if not empty.
  [[nodiscard]] Maybe<std::vector<const arm::Manipulator*>> free_arms(const std::string& arm) const;
  /// Objects of the scene by name or label, nearest first. Errors: none, or held ones only.
  [[nodiscard]] Maybe<std::vector<arm::WorldObject>> objects_to_pick(const std::string& name_or_label) const;
  [[nodiscard]] Status grasp(Hand& hand, const arm::PickPlan& plan, double time_s,
                             const MotionCallbacks& callbacks, extperfc::PickResult& result);
  /// Lifts the object that the gripper holds; releases it when that fails.
  [[nodiscard]] Status lift(Hand& hand, const arm::PickPlan& plan, double time_s,
                            const MotionCallbacks& callbacks);
  [[nodiscard]] Status still_holds(Hand& hand, const std::string& name, const MotionCallbacks& callbacks);
  [[nodiscard]] Status let_go(Hand& hand, const std::string& name, const Status& why);

  // Place.
  [[nodiscard]] Maybe<Hand*> holding(const extperfc::PlaceGoal& goal, CollisionObject* item);
  [[nodiscard]] Status put_down(Hand& hand, const CollisionObject& item, const arm::PlacePlan& plan,
                                double time_s, const MotionCallbacks& callbacks);
  [[nodiscard]] Status left_behind(Hand& hand, const CollisionObject& item, const MotionCallbacks& callbacks);

  // Motions.
  [[nodiscard]] Status move_joints(const Hand& hand, const arm::JointVector& goal, double time_s,
                                   const MotionCallbacks& callbacks);
  [[nodiscard]] Status move_along(const Hand& hand, const std::vector<arm::JointVector>& path, double time_s,
                                  const MotionCallbacks& callbacks);
  [[nodiscard]] Maybe<arm::MotionRequest> request(const Hand& hand, double time_s) const;
  [[nodiscard]] Status change(std::uint8_t operation, const std::string& name, const Hand* hand);

  PlanExecution& execution_;
  std::vector<Hand> hands_;
};

}  // namespace extperfc::ros_arm
