#pragma once

#include <memory>
#include <string>
#include <vector>

#include "extperfc/arm/collision_world.hpp"

#include "arm/collision/bodies.hpp"

namespace extperfc::arm {

/// A shape that moves with a body: of a link, or of an attached object.
struct MovingPart {
  std::string name;  ///< of the link or object
  int body{0};
  std::shared_ptr<const ConvexPart> part;
  Pose body_T_part{Pose::Identity()};
  std::vector<Ball> cover;  ///< in the body's frame
  Ball ball;                ///< in the body's frame: holds the part and the centres of the cover
  AxisReach reach;          ///< of `ball`
};

/// A shape that does not move: of the world, of a link of body 0, or attached to one.
struct Obstacle {
  std::string name;
  std::shared_ptr<const ConvexPart> part;
  Pose root_T_part{Pose::Identity()};
};

/// Two shapes that must keep `padding_m` from each other.
struct PartPair {
  int part{0};
  int other{0};  ///< obstacle, or second moving part if `self`
  bool self{false};
  int ancestor{0};  ///< body against which both move
  double padding_m{0};
};

/// Pairs [first_pair, pair_end) are all those between a body and an obstacle or between two bodies.
struct PairGroup {
  int body{0};
  int other{0};
  bool self{false};
  int first_pair{0}, pair_end{0};
};

/// A robot in a world, flat: everything that can touch. Moving parts are in order of their bodies.
struct Scene {
  std::vector<MovingPart> moving;
  std::vector<Obstacle> obstacles;
  std::vector<PartPair> pairs;
  std::vector<PairGroup> groups;
};

/// A ball about the balls of all parts on the body, in the body's frame; radius 0 when there are none.
[[nodiscard]] Ball body_ball(const Scene& scene, int body);

/// Errors: an object attached to a link that the robot lacks, an object named like a link. Pairs that are too
/// far apart in every position of the joints are left out.
[[nodiscard]] Result<Scene> make_scene(const Bodies& bodies, const CollisionWorld& world);

}  // namespace extperfc::arm
