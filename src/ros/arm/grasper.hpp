#pragma once

#include <memory>
#include <string>
#include <vector>

#include <extperfc/PickAction.h>
#include <extperfc/PlaceAction.h>

#include "extperfc/arm/grasp.hpp"
#include "extperfc/arm/grasp_choice.hpp"
#include "extperfc/arm/parallel_hand.hpp"

#include "ros/arm/gripper.hpp"
#include "ros/arm/plan_execution.hpp"

namespace extperfc::arm_node {

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
    ros_params::GripperParams names;
    arm::ParallelHand shape;
    arm::InverseKinematics kinematics;
    std::unique_ptr<Gripper> gripper;
    std::vector<arm::JointVector> put_down;  ///< posture found for place_at of the pick; empty if unknown
  };
  struct Choice {
    Hand* hand{nullptr};
    CollisionObject item;
    arm::GraspCandidate grasp;
    arm::JointPositions pregrasp;
    std::vector<arm::JointVector> approach;  ///< from pregrasp to grasp
    std::vector<arm::JointVector> lift;
    std::vector<arm::JointVector> put_down;  ///< see ReachableGrasps
    int tried{0};
  };
  template <typename T>
  using Maybe = tl::expected<T, Status>;

  Grasper(PlanExecution& execution, std::vector<Hand> hands)
      : execution_(execution), hands_(std::move(hands)) {}

  [[nodiscard]] Maybe<std::vector<Hand*>> free_hands(const std::string& arm);
  [[nodiscard]] Maybe<Choice> choose(const extperfc::PickGoal& goal, const MotionCallbacks& callbacks);
  /// Where a picked object has to be placed later.
  struct PlaceRequirement {
    std::vector<Pose> root_T_places;  ///< one of these must be reachable; empty: no requirement
    bool any_yaw{false};
  };
  [[nodiscard]] Maybe<PlaceRequirement> requirement_of(const extperfc::PickGoal& goal) const;
  /// Free distances that a grasp needs; `tilt_step_rad` between the approach directions.
  struct Clearances {
    double approach_m, lift_m, tilt_step_rad;
    bool padded;  ///< with the padding of plans, so that planning the same motion again succeeds
  };
  [[nodiscard]] Maybe<Choice> choose(const CollisionObject& item, const std::vector<Hand*>& hands,
                                     const Clearances& clearances, const PlaceRequirement& requirement,
                                     const MotionCallbacks& callbacks);
  /// Alternative paths; path_from() selects one by its first state.
  using Paths = std::vector<std::vector<arm::JointVector>>;
  /// Grasps of an object by one gripper, and what choose() needs to check them.
  struct ReachableGrasps {
    Hand* hand{nullptr};
    std::vector<arm::GraspCandidate> grasps;
    arm::CollisionChecker checker;  ///< with open fingers, which may touch the object
    arm::JointVector state;
    Paths lifts;  ///< of candidates, from straight_ways()
    /// The arm's posture at the required place, for the last candidate that motions_to_place() accepted.
    std::vector<arm::JointVector> put_down;
  };
  /// Errors: kNoGrasp where the shape does not fit the gripper; errors of the scene and the robot.
  [[nodiscard]] Maybe<ReachableGrasps> reachable_grasps(Hand& hand, const CollisionObject& item,
                                                        const Clearances& clearances);
  /// Straight collision-free approach and lift of a candidate, for choose(). Every lift found is added to
  /// `reachable`.
  [[nodiscard]] arm::StraightMotion straight_motions(ReachableGrasps& reachable, double lift_m) const;
  /// The same, but only for grasps from which the object can be placed as required. Keeps the references.
  [[nodiscard]] arm::StraightMotion motions_to_place(const CollisionObject& item, ReachableGrasps& reachable,
                                                     double lift_m, const PlaceRequirement& requirement,
                                                     const MotionCallbacks& callbacks);
  /// The arm's joint values with the object at one of the places.
  [[nodiscard]] std::optional<arm::JointVector> placed(const Hand& hand, const CollisionObject& item,
                                                       const Pose& root_T_tip,
                                                       const PlaceRequirement& requirement,
                                                       const MotionCallbacks& callbacks);
  [[nodiscard]] Status let_go(Hand& hand, const std::string& name, const Status& why);
  [[nodiscard]] Status grasp(const Choice& choice, double time_s, const MotionCallbacks& callbacks,
                             extperfc::PickResult& result);
  [[nodiscard]] Maybe<Hand*> holding(const extperfc::PlaceGoal& goal, CollisionObject* item);
  /// A place candidate with joint values above it and collision-free paths down and back.
  struct PlacePose {
    arm::PlaceCandidate where;
    arm::JointPositions above;
    std::vector<arm::JointVector> down;
    std::vector<arm::JointVector> back;
  };
  struct PlacePoseSearch {
    double retreat_m;
    double time_s;                         ///< maximum wall time for each attempt
    bool reserve;                          ///< adds attempts with more postures and a shorter descent
    std::vector<arm::JointVector> starts;  ///< see arm::GraspArm
  };
  /// One attempt of the search.
  struct PlacePoseAttempt {
    bool padded;
    arm::GraspChoiceOptions options;
    std::vector<arm::JointVector> starts;
  };
  /// `item` is held: frame_T_object is tip_T_object, and `carrying` is the world with the object attached.
  [[nodiscard]] Maybe<PlacePose> choose_place_pose(const Hand& hand, const CollisionObject& item,
                                                   const arm::CollisionWorld& carrying,
                                                   const Pose& root_T_object, bool any_yaw,
                                                   const PlacePoseSearch& search,
                                                   const MotionCallbacks& callbacks);
  [[nodiscard]] Maybe<PlacePose> choose_place_pose(const Hand& hand, const CollisionObject& item,
                                                   arm::CollisionWorld carrying,
                                                   const std::vector<arm::PlaceCandidate>& candidates,
                                                   const PlacePoseAttempt& how,
                                                   const MotionCallbacks& callbacks);
  [[nodiscard]] Status put_down(Hand& hand, const CollisionObject& item, const PlacePose& place_pose,
                                double time_s, const MotionCallbacks& callbacks);

  [[nodiscard]] Status move_joints(const Hand& hand, const arm::JointPositions& goal, double time_s,
                                   const MotionCallbacks& callbacks);
  [[nodiscard]] Status move_along(const Hand& hand, const std::vector<arm::JointVector>& path, double time_s,
                                  const MotionCallbacks& callbacks);
  [[nodiscard]] Maybe<arm::MotionRequest> request(const Hand& hand, double time_s) const;
  [[nodiscard]] Status change(std::uint8_t operation, const std::string& name, const Hand* hand);
  [[nodiscard]] Maybe<Pose> tip_now(const Hand& hand) const;

  PlanExecution& execution_;
  std::vector<Hand> hands_;
};

}  // namespace extperfc::arm_node
