#pragma once

#include <optional>
#include <vector>

#include "simulate/bodies/physics_world.hpp"
#include "simulate/bodies/robot_body.hpp"
#include "simulate/bodies/scenery.hpp"

namespace extperfc::simulate {

/// Watches the fingers' contacts and decides what each gripper holds.
///
/// A gripper touches a body when each finger's pad meets it from its own side. A touched body is held from
/// then on while the fingers are commanded to close; it is released when they are commanded to open, or when
/// it is far from the hand all the same.
class Grips {
 public:
  Grips(const BodiesParams& params, const RobotPlan& plan, PhysicsWorld& world, Scenery& scenery,
        RobotBody& robot);

  /// After every step.
  void update();
  /// Before the body is moved by someone else.
  void let_go_of(int body);

  /// By the driven finger's joint; nothing and 0 for other joints.
  [[nodiscard]] std::optional<int> gripped(int finger_joint) const;
  [[nodiscard]] double force(int finger_joint) const;  ///< [N]

 private:
  struct Touch {
    int gripper{0};
    int side{0};  // 0: driven finger, 1: the other one
    int body{0};
    double distance{0};  // [m], below 0: overlap
    double impulse{0};   // [N s]
  };
  struct Grip {
    std::optional<int> touched;  // body between the fingers
    int steps_touched{0};
    int steps_apart{0};
    double overlap_m{0};
    double force_n{0};
    bool held{false};
    double finger_position{0};           // of the driven finger when the body was taken
    Pose hand_T_body{Pose::Identity()};  // when it was taken
  };

  void find_touches();
  void add_touches(const btPersistentManifold& manifold);
  void add_touch(const Touch& touch);
  /// What both fingers touch: the means of their distances and impulses.
  [[nodiscard]] std::optional<Touch> between_fingers(int gripper) const;
  void update_touched(int gripper);
  void update_held(int gripper);
  [[nodiscard]] Eigen::Vector3d closing_direction(int gripper, int side) const;
  /// Whether the driven finger shall go on from there; `direction` 1 closes, -1 opens.
  [[nodiscard]] bool shall_go(double direction, int gripper, double from_m, double by_m) const;
  [[nodiscard]] bool closes(int gripper) const;
  /// Whether the fingers are commanded to let go of what is held.
  [[nodiscard]] bool opens(int gripper) const;
  [[nodiscard]] Pose hand_T_body(int gripper, int body) const;
  [[nodiscard]] int gripper_of(int finger_joint) const;

  BodiesParams params_;
  const RobotPlan* plan_;
  PhysicsWorld* world_;
  Scenery* scenery_;
  RobotBody* robot_;
  std::vector<Touch> touches_;
  std::vector<Grip> grips_;
};

}  // namespace extperfc::simulate
