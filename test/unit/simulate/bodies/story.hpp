#pragma once

#include "extperfc/base/rng.hpp"

#include "test/unit/simulate/bodies/baxter_arm.hpp"

namespace extperfc::simulate {

inline WorldSpec clutter() {
  WorldSpec world;
  world.bodies = {make_floor(),
                  body("table", Mobility::kFixed, box_of(0.6, 1.2, 0.03), make_pose({0.9, 0.3, 0.685}))};
  const std::vector<Geometry> shapes{Sphere{0.025}, box_of(0.05, 0.05, 0.05), Cone{0.03, 0.08}};
  for (int i = 0; i < 6; ++i)
    world.bodies.push_back(body("object" + std::to_string(i), Mobility::kLoose, shapes[i % 3],
                                make_pose({0.7 + 0.06 * (i % 3), 0.2 + 0.07 * (i / 3), 0.76 + 0.02 * i}),
                                0.08));
  PersonSpec person;
  person.path_m = {{2, 0}};
  world.people = {person};
  return world;
}

/// Random commands to everything; the same for the same seed.
class Story {
 public:
  explicit Story(bool dynamic) : bodies_(make_bodies(clutter(), mobile_baxter(), untucked(), dynamic)) {}

  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      if (time_ % 60 == 0) command();
      root_ = advance(root_, twist_, kStep);
      bodies_->set_root(to_pose(root_));
      bodies_->set_person(0, {2 - 0.5 * time_ * kStep, 0.1, 0});
      bodies_->step();
      ++time_;
    }
  }

  [[nodiscard]] std::vector<double> state() const {
    std::vector<double> values;
    const auto add = [&](const Pose& pose) { values.insert(values.end(), pose.data(), pose.data() + 16); };
    for (std::size_t i = 0; i < mobile_baxter().joints().size(); ++i) {
      values.push_back(bodies_->position(static_cast<int>(i)));
      values.push_back(bodies_->velocity(static_cast<int>(i)));
      values.push_back(bodies_->effort(static_cast<int>(i)));
    }
    for (int i = 0; i < 8; ++i) add(bodies_->world_T_body(i));
    add(bodies_->world_T_link(link_index("left_gripper")));
    return values;
  }

 private:
  void command() {
    for (const char* side : {"left", "right"})
      for (const int joint : arm_joints(side))
        bodies_->set_target(joint,
                            {Drive::kPosition, bodies_->position(joint) + rng_.uniform(-0.4, 0.4), 0, 0, 0});
    bodies_->set_target(joint_index("l_gripper_l_finger_joint"),
                        {Drive::kPosition, rng_.uniform(0, 0.02), 0, 0, 0});
    twist_ = {rng_.uniform(-0.3, 0.3), rng_.uniform(-0.3, 0.3), rng_.uniform(-0.5, 0.5)};
    if (rng_.chance(0.3)) {
      EXPECT_TRUE(bodies_->move_body(rng_.integer(2, 7), make_pose({0.8, 0.3, 0.9})));
    }
  }

  std::unique_ptr<Bodies> bodies_;
  Rng rng_{17};
  Pose2 root_;
  Twist2 twist_;
  int time_{0};
};

}  // namespace extperfc::simulate
