#include "simulate/worlds/varied_world.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "extperfc/base/math.hpp"
#include "extperfc/world/shape_extent.hpp"

#include "simulate/worlds/random_look.hpp"
#include "simulate/worlds/random_room.hpp"
#include "simulate/worlds/solid.hpp"
#include "simulate/worlds/varied_objects.hpp"

namespace extperfc::simulate {

namespace {

constexpr int kPlacementTries = 25;
constexpr double kCeiling_m = 2.6;

struct Placed {
  Eigen::Vector2d at_m;  ///< on the surface
  double reach_m;
  double top_m;  ///< above the surface
};

/// A surface with what stands on it.
class Ground {
 public:
  Ground(RandomScene& scene, const TableTop& top) : scene_(scene), top_(top) {}

  /// Puts an object somewhere in any orientation.
  bool put(const ObjectModel& model, const std::string& kind) {
    return put(model, kind, random_rotation(scene_.rng()));
  }
  /// Puts an object as it stands by itself.
  bool put_upright(const ObjectModel& model, const std::string& kind) {
    return put(model, kind, upright(0, 0, 0, scene_.rng().uniform(-kPi, kPi)));
  }
  /// Holds an object in the air with a hand or a gripper.
  void hold(const ObjectModel& model) {
    Rng& rng = scene_.rng();
    const double reach = reach_of(model, Pose::Identity());
    Placed placed{random_point(rng, 0), reach, 0};
    put_at(model, "held", random_rotation(rng), placed, rng.uniform(0.05, 0.5));
    const Eigen::Vector3d middle = scene_.world().bodies.back().world_T_body.translation();
    const bool by_hand = rng.chance(0.5);
    const ObjectModel holder = by_hand ? hand(rng) : gripper_fingers(rng, 1.6 * reach);
    Pose pose = Pose::Identity();
    pose.translation() = middle;
    const double roll = rng.uniform(-kPi, kPi);
    const double pitch = rng.uniform(-0.3, 1.2);
    const double yaw = rng.uniform(-kPi, kPi);
    pose.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()));
    pose.translate(Eigen::Vector3d(by_hand ? -0.1 - 0.4 * reach : -0.1, 0, by_hand ? reach : 0));
    scene_.put(holder, by_hand ? "hand" : "gripper", pose);
  }

 private:
  /// With luck close to or on top of another; false: no room.
  bool put(const ObjectModel& model, const std::string& kind, const Pose& rotation) {
    Rng& rng = scene_.rng();
    const double reach = reach_of(model, rotation);
    Placed placed{{0, 0}, reach, 0};
    const bool on_top = !placed_.empty() && rng.chance(0.2);
    const double z = on_top ? place_on_top(placed) : 0;
    if (!on_top && !find_gap(placed)) return false;
    put_at(model, kind, rotation, placed, z);
    return true;
  }

  static Pose random_rotation(Rng& rng) {
    Pose pose = Pose::Identity();
    pose.rotate(Eigen::AngleAxisd(rng.uniform(-kPi, kPi), Eigen::Vector3d::UnitZ()));
    const double kind = rng.uniform(0, 1);
    double tilt = 0;
    if (kind > 0.88)
      tilt = rng.uniform(0, kPi);
    else if (kind > 0.7)
      tilt = kRightAngle + rng.normal(0, 0.25);
    else if (kind > 0.6)
      tilt = rng.normal(0, 0.3);
    const double axis = rng.uniform(-kPi, kPi);
    pose.rotate(Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(axis), std::sin(axis), 0)));
    return pose;
  }

  static double reach_of(const ObjectModel& model, const Pose& rotation) {
    double reach = 0;
    for (const Shape& shape : model.shapes)
      if (const auto polygon = outline(shape.geometry, rotation * shape.body_T_shape, -1e3, 1e3))
        for (const auto& point : *polygon) reach = std::max(reach, point.norm());
    return reach;
  }

  [[nodiscard]] Eigen::Vector2d random_point(Rng& rng, double reach) const {
    const Eigen::Vector2d half = (top_.half_m - Eigen::Vector2d::Constant(reach)).cwiseMax(0.01);
    return {rng.uniform(-half.x(), half.x()), rng.uniform(-half.y(), half.y())};
  }

  const Placed& any_placed(Rng& rng) const {
    return placed_.at(static_cast<std::size_t>(rng.integer(0, static_cast<int>(placed_.size()) - 1)));
  }

  double place_on_top(Placed& placed) {
    Rng& rng = scene_.rng();
    const Placed& below = any_placed(rng);
    const double angle = rng.uniform(-kPi, kPi);
    placed.at_m =
        below.at_m + below.reach_m * rng.uniform(0, 0.5) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    return below.top_m;
  }

  bool find_gap(Placed& placed) {
    Rng& rng = scene_.rng();
    if ((top_.half_m.array() < placed.reach_m).any()) return false;
    for (int attempt = 0; attempt < kPlacementTries; ++attempt) {
      placed.at_m = random_point(rng, placed.reach_m);
      if (!placed_.empty() && rng.chance(0.6)) {
        const Placed& other = any_placed(rng);
        const double angle = rng.uniform(-kPi, kPi);
        const double apart = other.reach_m + placed.reach_m + std::abs(rng.normal(0, 0.02));
        placed.at_m = other.at_m + apart * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      }
      const auto clear = [&placed](const Placed& other) {
        return (other.at_m - placed.at_m).norm() > 0.85 * (other.reach_m + placed.reach_m);
      };
      const bool inside = ((placed.at_m.cwiseAbs() - top_.half_m).array() < -0.5 * placed.reach_m).all();
      if (inside && std::all_of(placed_.begin(), placed_.end(), clear)) return true;
    }
    return false;
  }

  void put_at(const ObjectModel& model, const std::string& kind, const Pose& rotation, Placed placed,
              double z) {
    const VerticalExtent extent = vertical_extent(model.shapes, rotation);
    Pose pose = Pose::Identity();
    pose.translation() = Eigen::Vector3d(placed.at_m.x(), placed.at_m.y(), z - extent.low_m);
    scene_.put(model, kind, top_.world_T_surface * pose * rotation);
    placed.top_m = z + extent.high_m - extent.low_m;
    placed_.push_back(placed);
  }

  RandomScene& scene_;
  TableTop top_;
  std::vector<Placed> placed_;
};

LightSpec odd_light(Rng& rng, const WorldSpec& world) {
  LightSpec light = random_light(rng, world.min_m, world.max_m, kCeiling_m);
  if (rng.chance(0.5)) return light;
  light.position_m.z() = rng.uniform(1.2, kCeiling_m - 0.05);
  const double total = std::exp(rng.normal(0, 0.35));
  const double fraction = rng.uniform(0.15, 0.92);
  light.direct = static_cast<float>(1.3 * total * fraction);
  light.ambient = static_cast<float>(total * (1 - fraction));
  light.sky = random_colour(rng, {0, 0.7, 0.4, 1});
  return light;
}

/// A table top, or a part of the floor before the robot.
TableTop random_ground(RandomScene& scene) {
  Rng& rng = scene.rng();
  TableTop table = put_table(scene);
  if (rng.chance(0.8)) return table;
  const double front = table.world_T_surface.translation().x() + table.half_m.x() + 0.7;
  return {upright(std::min(front, scene.world().max_m.x() - 0.7), rng.uniform(-0.4, 0.4), 0, 0), {0.6, 0.8}};
}

void fill(RandomScene& scene, Ground& ground) {
  Rng& rng = scene.rng();
  int targets = rng.integer(1, 8);
  int others = rng.integer(2, rng.chance(0.3) ? 16 : 9);
  if (rng.chance(0.35)) ground.hold(rng.chance(0.75) ? varied_target(rng) : look_alike(rng));
  while (targets + others > 0) {
    const bool target = rng.integer(1, targets + others) <= targets;
    ground.put(target ? varied_target(rng) : look_alike(rng), target ? "target" : "other");
    (target ? targets : others) -= 1;
  }
  if (rng.chance(0.25)) ground.put_upright(cable(rng), "cable");
  if (rng.chance(0.2)) ground.put_upright(hand(rng), "hand");
}

}  // namespace

WorldSpec varied_world(std::uint64_t seed) {
  RandomScene scene("varied_" + std::to_string(seed), seed);
  Rng& rng = scene.rng();
  WorldSpec& world = scene.world();
  world.min_m = {-rng.uniform(1.2, 2.2), -rng.uniform(1.6, 3.2)};
  world.max_m = {rng.uniform(2.9, 5.0), rng.uniform(1.6, 3.2)};
  world.light = odd_light(rng, world);
  put_room(scene, kCeiling_m);
  const TableTop top = random_ground(scene);
  scene.reserve({-0.9, -0.9}, {0.9, 0.9});
  const Eigen::Vector2d inset = Eigen::Vector2d::Constant(0.115);
  furnish_walls(scene, world.min_m + inset, world.max_m - inset, rng.integer(3, 9), kCeiling_m);
  Ground ground(scene, top);
  fill(scene, ground);
  return world;
}

}  // namespace extperfc::simulate
