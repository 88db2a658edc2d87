#include "simulate/worlds/world_checks.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "simulate/worlds/solid.hpp"

namespace extperfc::simulate {

namespace {

constexpr double kOverlap = 0.005;     // obvious [m]
constexpr double kRobotRadius = 0.42;  // of the base [m]
constexpr double kPersonRadius = 0.2;  // [m]
constexpr double kPersonHeight = 1.8;  // [m]
constexpr double kFloor = 0.03;        // what ends below can be stepped on [m]
constexpr double kStride = 0.1;        // between points at which a path is checked [m]

struct Outline {
  const PlacedObject* object;
  Polygon polygon;
};

/// Outlines of fixed shapes that are obstacles for something as tall as a person.
std::vector<Outline> obstacles(const std::vector<PlacedObject>& objects) {
  std::vector<Outline> list;
  for (const PlacedObject& object : objects) {
    if (object.body.mobility != Mobility::kFixed) continue;
    for (const Shape& shape : object.body.shapes)
      if (auto polygon =
              outline(shape.geometry, object.body.world_T_body * shape.body_T_shape, kFloor, kPersonHeight))
        list.push_back({&object, std::move(*polygon)});
  }
  return list;
}

const Outline* near(const std::vector<Outline>& list, const Eigen::Vector2d& point, double radius) {
  const auto found = std::find_if(list.begin(), list.end(), [&](const Outline& outline) {
    return distance_m(outline.polygon, point) < radius;
  });
  return found == list.end() ? nullptr : &*found;
}

bool within(const WorldSpec& world, const Eigen::Vector2d& point) {
  constexpr double kSlack = 1e-6;
  return ((point - world.min_m).array() >= -kSlack).all() && ((world.max_m - point).array() >= -kSlack).all();
}

std::string text_of(const Eigen::Vector2d& point) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(3);
  out << '[' << point.x() << ", " << point.y() << ']';
  return out.str();
}

void check_places(const WorldSpec& world, const std::vector<PlacedObject>& objects, Problems& problems) {
  for (const PlacedObject& object : objects)
    if (object.bounded && !within(world, object.body.world_T_body.translation().head<2>()))
      problems.add(object.origin.line, object.origin.key_path,
                   "\"" + object.body.name + "\" stands outside the floor plan: move it or widen floor_plan");
}

void check_overlaps(const std::vector<PlacedObject>& objects, Problems& problems) {
  for (std::size_t i = 0; i < objects.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const BodySpec& a = objects[i].body;
      const BodySpec& b = objects[j].body;
      if (a.mobility != Mobility::kLoose && b.mobility != Mobility::kLoose) continue;
      if (certain_overlap_m(a, b) > kOverlap)
        problems.add(objects[i].origin.line, objects[i].origin.key_path,
                     "\"" + a.name + "\" and \"" + b.name + "\" are inside each other: move one of them");
    }
}

void check_robot(const WorldSpec& world, const std::vector<Outline>& fixed, const Origin& origin,
                 Problems& problems) {
  const Eigen::Vector2d at(world.robot_start.x, world.robot_start.y);
  if (!within(world, at))
    problems.add(origin.line, origin.key_path,
                 "the robot starts outside the floor plan: move it or widen floor_plan");
  if (const Outline* obstacle = near(fixed, at, kRobotRadius))
    problems.add(origin.line, origin.key_path,
                 "the robot starts inside or too near to \"" + obstacle->object->body.name +
                     "\" (its base needs 0.42 m around it): move one of them");
}

/// The first point of a path that is in a fixed object or outside; points between included.
void check_path(const WorldSpec& world, const std::vector<Outline>& fixed, const PersonSpec& person,
                const Origin& origin, Problems& problems) {
  const std::size_t count = person.path_m.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (!within(world, person.path_m[i]))
      return problems.add(origin.line, origin.key_path,
                          "point " + text_of(person.path_m[i]) + " is outside the floor plan: move it");
    if (i + 1 == count && !person.closed && count > 1) return;
    const Eigen::Vector2d segment = person.path_m[(i + 1) % count] - person.path_m[i];
    const int steps = static_cast<int>(std::ceil(segment.norm() / kStride));
    for (int step = 0; step <= steps; ++step) {
      const Eigen::Vector2d point =
          person.path_m[i] + segment * (steps == 0 ? 0.0 : static_cast<double>(step) / steps);
      if (const Outline* hit = near(fixed, point, kPersonRadius))
        return problems.add(origin.line, origin.key_path,
                            "\"" + person.name + "\" walks into \"" + hit->object->body.name + "\" near " +
                                text_of(point) + ": route the path around it");
    }
  }
}

void check_paths(const WorldSpec& world, const std::vector<Outline>& fixed, std::size_t first,
                 const std::vector<Origin>& people, Problems& problems) {
  for (std::size_t i = first; i < world.people.size(); ++i)
    check_path(world, fixed, world.people[i], people[i], problems);
}

}  // namespace

double certain_overlap_m(const BodySpec& a, const BodySpec& b) {
  double deepest = 0;
  for (const Shape& one : a.shapes)
    for (const Shape& other : b.shapes) {
      const Pose pose = a.world_T_body * one.body_T_shape;
      const Pose other_pose = b.world_T_body * other.body_T_shape;
      const ShapeBox box = inner_box(one.geometry);
      const ShapeBox other_box = inner_box(other.geometry);
      if ((pose.translation() - other_pose.translation()).norm() >
          box.half_m.norm() + box.centre_m.norm() + other_box.half_m.norm() + other_box.centre_m.norm())
        continue;
      deepest = std::max(deepest, box_overlap_m(box, pose, other_box, other_pose));
    }
  return deepest;
}

void check_world(const WorldSpec& world, const std::vector<PlacedObject>& objects, const Origin& robot,
                 const std::vector<Origin>& people, Problems& problems) {
  const std::vector<Outline> fixed = obstacles(objects);
  check_places(world, objects, problems);
  check_overlaps(objects, problems);
  check_robot(world, fixed, robot, problems);
  check_paths(world, fixed, 0, people, problems);
}

void check_people(const WorldSpec& world, std::size_t first, const std::vector<Origin>& people,
                  Problems& problems) {
  std::vector<PlacedObject> objects;
  objects.reserve(world.bodies.size());
  for (const BodySpec& body : world.bodies) objects.emplace_back().body = body;
  check_paths(world, obstacles(objects), first, people, problems);
}

}  // namespace extperfc::simulate
