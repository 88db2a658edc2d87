#pragma once

#include <functional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "extperfc/arm/collision_world.hpp"
#include "extperfc/arm/grasp.hpp"
#include "extperfc/arm/grasp_choice.hpp"
#include "extperfc/arm/motion_pipeline.hpp"
#include "extperfc/arm/status.hpp"

namespace extperfc::arm {

/// An arm and the gripper that it carries.
struct Manipulator {
  std::string name;          ///< for messages, e.g. left
  std::string group;         ///< of RobotArms: the joints of the kinematics
  std::string finger_joint;  ///< the driven one
  ParallelHand hand;
  InverseKinematics kinematics;  ///< from the robot's root link to the hand's tip

  /// Errors: an unknown group or one without a joint that moves the tip, no chain to the tip, those of
  /// hand_of().
  [[nodiscard]] static Result<Manipulator> make(const RobotArms& arms, const std::string& name,
                                                const std::string& group, const std::string& tip_link,
                                                const std::string& finger_joint);
};

/// Where an object shall stand, and the straight paths there.
struct PlaceRequirement {
  std::vector<Pose> root_T_places;  ///< alternatives, tried in this order
  bool any_yaw{false};              ///< any rotation about the vertical through its origin is accepted
  double lower_m{0.08};             ///< straight descent before opening the gripper; 0 to 0.5
  double retreat_m{0.1};            ///< straight path back after opening; 0 to 0.5
};

struct PickTask {
  JointPositions start;                          ///< of every moving joint of the robot that is known
  std::vector<const Manipulator*> manipulators;  ///< not empty; their grippers are
  std::vector<WorldObject> objects;              ///< as in the world: alternatives, tried in this order
  GraspParams grasp;
  PlaceRequirement place;           ///< only grasps from which the object can be placed so; no places: any
  double attempt_time_s{5};         ///< maximum wall time of each attempt
  std::function<bool()> cancelled;  ///< may be empty
};

struct PickPlan {
  const Manipulator* manipulator{nullptr};
  WorldObject object;
  GraspCandidate grasp;
  /// To the grasp and, with the object, up; `place` with a required place.
  StraightPaths paths;
  int tried{0};  ///< candidates of the attempt that succeeded
};

/// The best grasp of one of the objects that an arm reaches with a straight free approach and lift: first
/// with the padding of plans and the given distances, then with smaller ones and more approach directions.
/// Errors: kNoGrasp, with the reason for each gripper; kCancelled; kNoJointStates for a joint without a
/// position; kInternal. `world` and the task's start are read once: a choice among several objects takes up
/// to two attempts for each, and what moved meanwhile is found when the motion is planned.
[[nodiscard]] tl::expected<PickPlan, Status> plan_pick(MotionPipeline& pipeline, const PickTask& task,
                                                       const CollisionWorld& world);

struct PlaceTask {
  JointPositions start;                     ///< of every moving joint of the robot that is known
  const Manipulator* manipulator{nullptr};  ///< holds the object; not null
  AttachedObject object;                    ///< as in the world, at the hand's tip
  PlaceRequirement place;                   ///< at least one place
  double attempt_time_s{5};                 ///< maximum wall time of each attempt
  bool thorough{true};                ///< adds attempts with more postures and yaws, and a shorter descent
  std::vector<JointVector> starts;    ///< see GraspArm
  std::function<bool()> cancelled{};  ///< may be empty
};

struct PlacePlan {
  PlaceCandidate candidate;
  StraightPaths paths;  ///< down with the object, back without it
  bool clear{false};    ///< the retreat ends with all of the object in front of the fingers: they may close
};

/// A way to place a held object: first with the padding of plans, then without. A ball may rest in any
/// orientation, so for it also approaches from vertical to nearly horizontal are tried. The retreat is never
/// shortened, because the fingers have to leave the object. Errors: kGoalUnreachable, with the reason;
/// kCancelled; kNoJointStates for a joint without a position; kInvalidRequest without a place; kInternal.
[[nodiscard]] tl::expected<PlacePlan, Status> plan_place(MotionPipeline& pipeline, const PlaceTask& task,
                                                         const CollisionWorld& world);

}  // namespace extperfc::arm
