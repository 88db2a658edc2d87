#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/grasp.hpp"
#include "extperfc/arm/inverse_kinematics.hpp"
#include "extperfc/arm/joint_vector.hpp"

namespace extperfc::arm {

/// What a candidate needs beside a posture; joint values are of the arm's chain.
struct StraightPaths {
  std::vector<JointVector> approach;  ///< from the pregrasp to the grasp, both included
  /// From the grasp on: the lift, or the retreat of a gripper that opened.
  std::vector<JointVector> departure;
  /// With the object at the place that is required later; no values where none is required.
  JointVector place;
};

/// Straight collision-free paths to and from the posture `grasp` of a candidate, which is given with its
/// index in the list; std::nullopt without such paths.
using StraightMotion = std::function<std::optional<StraightPaths>(
    std::size_t index, const GraspCandidate& candidate, const JointVector& grasp)>;

/// An arm that may grasp. What it points to must outlive the call.
struct GraspArm {
  std::string name;
  const InverseKinematics* kinematics{nullptr};  ///< from the robot's root link to the hand's tip
  /// Of a model that moves the arm's joints and perhaps more, with open fingers, in a world in which the
  /// fingers may touch the object: see allow_grasp().
  CollisionChecker* checker{nullptr};
  JointVector state;  ///< of all joints of the checker's model: where the robot is
  /// For this arm's hand, best first; nullptr: those given to choose_grasp(). May be empty.
  const std::vector<GraspCandidate>* grasps{nullptr};
  /// Empty: the approach alone, by inverse kinematics at places at most 0.01 m apart, with a free motion
  /// proven between them.
  StraightMotion straight;
  /// Values of the arm's joints to look for postures from first, before where it is; may be empty.
  std::vector<JointVector> starts{};
};

/// Why an arm rejected a grasp candidate.
enum class GraspRefusal {
  kOutOfReach,  ///< no joint values
  kLimits,      ///< only beyond the joints' limits
  kCollision,   ///< every posture found collides
  kTimeout,     ///< the solver's time was up
  kNoPath,      ///< no straight collision-free path between pregrasp and grasp
};
inline constexpr int kGraspRefusals = 5;

[[nodiscard]] const char* to_string(GraspRefusal refusal);

struct GraspChoiceOptions {
  double timeout_s{2.0};            ///< wall time for all; above 0
  double ik_timeout_s{0.01};        ///< of each call of the solver; above 0
  int ik_restarts{15};              ///< of each call of the solver; 0 or more
  int postures{3};                  ///< tried for each candidate and arm; 1 to 20
  std::function<bool()> cancelled;  ///< asked between postures; may be empty
};

struct GraspChoice {
  int arm{-1};          ///< index
  int candidate{-1};    ///< index in the list of this arm
  StraightPaths paths;  ///< with an approach
  int tried{0};         ///< candidates

  [[nodiscard]] const JointVector& pregrasp() const { return paths.approach.front(); }
  [[nodiscard]] const JointVector& grasp() const { return paths.approach.back(); }
};

struct NoGrasp {
  std::vector<std::array<int, kGraspRefusals>> refusals;  ///< per arm, by GraspRefusal
  int tried{0};                                           ///< candidates of the longest list
  bool timed_out{false};                                  ///< or cancelled: not all candidates were tried
  std::string message;  ///< one line: per arm how many candidates failed for which reason
};

/// The first candidate that one of the arms reaches free of collisions, with a straight collision-free path
/// from its pregrasp. Arms with lists of their own are asked rank by rank. Where both reach theirs, an arm
/// whose gripper has at least 3 mm to spare comes before one without, then the arm that has to move less
/// (largest joint displacement). Equal inputs give equal results as long as no time is up. Throws
/// std::invalid_argument for an arm without kinematics or checker, a state or start of another size, a chain
/// with a joint that the checker's model does not move, or no arm.
[[nodiscard]] tl::expected<GraspChoice, NoGrasp> choose_grasp(const std::vector<GraspCandidate>& candidates,
                                                              const std::vector<GraspArm>& arms,
                                                              const GraspChoiceOptions& options = {});

/// The hand's fingers may touch the object of that name.
void allow_grasp(CollisionWorld& world, const std::string& object, const ParallelHand& hand);
/// The object of that name, with these shapes at this pose, may touch its support: all objects that do not
/// reach above its lower side.
void allow_support(CollisionWorld& world, const std::string& object, const std::vector<Shape>& shapes,
                   const Pose& root_T_object);

}  // namespace extperfc::arm
