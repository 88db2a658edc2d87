#pragma once

#include <memory>
#include <string>
#include <vector>

#include <extperfc/PickAction.h>
#include <extperfc/PlaceAction.h>

#include "extperfc/arm/grasp.hpp"
#include "extperfc/arm/grasp_choice.hpp"
#include "extperfc/arm/parallel_hand.hpp"

#include "ros/arm/commander.hpp"
#include "ros/arm/gripper.hpp"

namespace extperfc::arm_node {

/// Picks things of the scene up and puts them down. Not thread-safe: whoever calls has the arms.
class Grasper {
 public:
  /// Errors: a hand that the robot does not have, see arm::hand_of(). The commander is kept.
  [[nodiscard]] static Result<std::unique_ptr<Grasper>> make(const ros::NodeHandle& handle,
                                                             Commander& commander);

  [[nodiscard]] Ending pick(const extperfc::PickGoal& goal, const Hooks& hooks, extperfc::PickResult& result);
  [[nodiscard]] Ending place(const extperfc::PlaceGoal& goal, const Hooks& hooks,
                             extperfc::PlaceResult& result);

 private:
  struct Hand {
    ros_params::HandParams names;
    arm::ParallelHand shape;
    arm::InverseKinematics kinematics;
    std::unique_ptr<Gripper> gripper;
    std::vector<arm::JointVector> put_down;  ///< the posture that what it holds was picked for, or nothing
  };
  struct Choice {
    Hand* hand{nullptr};
    SceneItem item;
    arm::GraspCandidate grasp;
    arm::JointPositions pregrasp;
    std::vector<arm::JointVector> approach;  ///< from pregrasp to grasp
    std::vector<arm::JointVector> lift;
    std::vector<arm::JointVector> put_down;  ///< see Reach
    int tried{0};
  };
  template <typename T>
  using Maybe = tl::expected<T, Ending>;

  Grasper(Commander& commander, std::vector<Hand> hands) : commander_(commander), hands_(std::move(hands)) {}

  [[nodiscard]] Maybe<std::vector<Hand*>> free_hands(const std::string& arm);
  [[nodiscard]] Maybe<Choice> choose(const extperfc::PickGoal& goal, const Hooks& hooks);
  /// What a thing is picked for.
  struct Errand {
    std::vector<Pose> root_T_places;  ///< to be put down at one of these later; empty: not known
    bool any_yaw{false};
  };
  [[nodiscard]] Maybe<Errand> errand_of(const extperfc::PickGoal& goal) const;
  /// What a grasp has to have room for; `tilt_step_rad` between the approaches that are tried.
  struct Room {
    double approach_m, lift_m, tilt_step_rad;
    bool padded;  ///< with the distance that plans keep: what is planned again later succeeds again
  };
  [[nodiscard]] Maybe<Choice> choose(const SceneItem& item, const std::vector<Hand*>& hands, const Room& room,
                                     const Errand& errand, const Hooks& hooks);
  /// Where a way ends, and the way that goes on from there.
  using WaysOn = std::vector<std::vector<arm::JointVector>>;
  /// How one hand could take a thing.
  struct Reach {
    Hand* hand{nullptr};
    std::vector<arm::GraspCandidate> grasps;
    arm::CollisionChecker checker;  ///< with open fingers, which may touch the thing
    arm::JointVector state;
    WaysOn lifts;  ///< of candidates, from straight_ways()
    /// The arm's posture at the place of the errand, for the candidate that ways_to_place() liked last.
    std::vector<arm::JointVector> put_down;
  };
  /// Ending: kNoGrasp where the shape does not fit the hand; the scene's and the robot's.
  [[nodiscard]] Maybe<Reach> reach_of(Hand& hand, const SceneItem& item, const Room& room);
  /// Approach and lift of a candidate, straight and free, for choose(). Every lift found is added to the
  /// reach.
  [[nodiscard]] arm::StraightWay straight_ways(Reach& reach, double lift_m) const;
  /// The same where the thing, grasped so, can be put down as the errand wants it. References are kept.
  [[nodiscard]] arm::StraightWay ways_to_place(const SceneItem& item, Reach& reach, double lift_m,
                                               const Errand& errand, const Hooks& hooks);
  /// The arm's joint values with the thing at one of the places.
  [[nodiscard]] std::optional<arm::JointVector> placed(const Hand& hand, const SceneItem& item,
                                                       const Pose& root_T_tip, const Errand& errand,
                                                       const Hooks& hooks);
  [[nodiscard]] Ending let_go(Hand& hand, const std::string& name, const Ending& why);
  [[nodiscard]] Ending grasp(const Choice& choice, double time_s, const Hooks& hooks,
                             extperfc::PickResult& result);
  [[nodiscard]] Maybe<Hand*> holding(const extperfc::PlaceGoal& goal, SceneItem* item);
  /// Where to put it: a candidate with joint values above it, from where the ways down and back are free.
  struct Spot {
    arm::PlaceCandidate where;
    arm::JointPositions above;
    std::vector<arm::JointVector> down;
    std::vector<arm::JointVector> back;
  };
  struct SpotSearch {
    double retreat_m;
    double time_s;  ///< wall time for each kind of way, at most
    bool reserve;   ///< where nothing is found, looks harder, and for less of the way down
    std::vector<arm::JointVector> starts;  ///< see arm::GraspArm
  };
  /// One kind of way to look for.
  struct SpotTry {
    bool padded;
    arm::GraspChoiceOptions options;
    std::vector<arm::JointVector> starts;
  };
  /// `item` is held: frame_T_object is tip_T_object, and `carrying` is the world with it in the hand.
  [[nodiscard]] Maybe<Spot> choose_spot(const Hand& hand, const SceneItem& item,
                                        const arm::CollisionWorld& carrying, const Pose& root_T_object,
                                        bool any_yaw, const SpotSearch& search, const Hooks& hooks);
  [[nodiscard]] Maybe<Spot> choose_spot(const Hand& hand, const SceneItem& item, arm::CollisionWorld carrying,
                                        const std::vector<arm::PlaceCandidate>& candidates,
                                        const SpotTry& how, const Hooks& hooks);
  [[nodiscard]] Ending put_down(Hand& hand, const SceneItem& item, const Spot& spot, double time_s,
                                const Hooks& hooks);

  [[nodiscard]] Ending move_joints(const Hand& hand, const arm::JointPositions& goal, double time_s,
                                   const Hooks& hooks);
  [[nodiscard]] Ending move_along(const Hand& hand, const std::vector<arm::JointVector>& path, double time_s,
                                  const Hooks& hooks);
  [[nodiscard]] Maybe<arm::MotionRequest> request(const Hand& hand, double time_s) const;
  [[nodiscard]] Ending change(std::uint8_t operation, const std::string& name, const Hand* hand);
  [[nodiscard]] Maybe<Pose> tip_now(const Hand& hand) const;

  Commander& commander_;
  std::vector<Hand> hands_;
};

}  // namespace extperfc::arm_node
