#pragma once

#include <string>

namespace extperfc {

/// A robot of three links: base -- slide (prismatic along y) --> carriage -- swivel (revolute about z) -->
/// tool. Each part may be replaced, so that a test can break one.
struct RobotText {
  std::string carriage{R"(<inertial><mass value="2"/><origin xyz="0 0 0.1"/>
      <inertia ixx="0.1" ixy="0.01" ixz="0" iyy="0.2" iyz="0" izz="0.3"/></inertial>
      <visual><geometry><box size="0.1 0.2 0.3"/></geometry>
        <material name="red"><color rgba="0.8 0.1 0.05 1"/></material></visual>
      <collision><origin xyz="0 0 0.15"/><geometry><cylinder radius="0.05" length="0.3"/></geometry></collision>)"};
  std::string slide{
      R"(<axis xyz="0 2 0"/><limit lower="-0.5" upper="0.25" effort="20" velocity="0.4"/><origin xyz="1 0 0"/>)"};
  std::string swivel{
      R"(<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="3" velocity="2"/><origin xyz="0 0 0.5"/>)"};
  std::string swivel_type{"revolute"};
  std::string more{};  ///< further elements

  [[nodiscard]] std::string xml() const {
    return R"(<?xml version="1.0"?><robot name="slider"><link name="base"/><link name="carriage">)" +
           carriage +
           R"(</link><link name="tool"/>
      <joint name="slide" type="prismatic"><parent link="base"/><child link="carriage"/>)" +
           slide + R"(</joint><joint name="swivel" type=")" + swivel_type +
           R"("><parent link="carriage"/><child link="tool"/>)" + swivel + "</joint>" + more + "</robot>";
  }
};

}  // namespace extperfc
