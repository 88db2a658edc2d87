#include "simulate/worlds/object_reader.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/base/math.hpp"
#include "extperfc/base/text.hpp"

#include "simulate/worlds/object_model_reader.hpp"

namespace extperfc::simulate {

namespace {

constexpr int kMaxCopies = 100;
constexpr int kDeepest = 8;                // groups in groups: an anchor may hold itself
constexpr std::size_t kMaxObjects = 5000;  // groups of groups of copies may multiply

/// `mobility`, `mass`, `label`, `friction` and `rolling_friction`.
void read_body_keys(YamlMap& map, ObjectModel& model) {
  model.mobility = static_cast<Mobility>(
      map.choice("mobility", {"fixed", "movable", "loose"}, static_cast<std::size_t>(model.mobility)));
  const bool loose = model.mobility == Mobility::kLoose;
  if (map.has("mass"))
    model.mass_kg = map.number("mass", {1e-4, 1000});
  else if (loose && model.mass_kg <= 0)
    map.problem("mass", "a loose body needs a mass: add `mass` in kg");
  else
    map.expect("mass");
  model.label = map.text("label", model.label);
  model.friction = map.number("friction", {0, 10}, model.friction);
  model.rolling_friction = map.number("rolling_friction", {0, 1}, model.rolling_friction);
}

/// `at`: [x, y] with z = 0, or [x, y, z].
Eigen::Vector3d place_of(YamlMap& map) {
  auto values = map.numbers("at", {2, 3}, kAny);
  if (!map.is_list("at")) values = {0, 0};  // missing: one problem is enough
  values.resize(3, 0.0);
  return {values[0], values[1], values[2]};
}

/// The opening's place: nearest segment to a point on the wall.
void locate_opening(YamlMap& map, const WallParams& wall, const Eigen::Vector2d& point, Opening& opening) {
  double nearest = wall.thickness_m;
  bool found = false;
  for (std::size_t i = 0; i < segment_count(wall); ++i) {
    const Eigen::Vector2d& from = wall.path_m[i];
    const Eigen::Vector2d along = (wall.path_m[(i + 1) % wall.path_m.size()] - from).normalized();
    const double at = along.dot(point - from);
    const double off = std::abs(along.x() * (point - from).y() - along.y() * (point - from).x());
    if (at < 0 || at > segment_length_m(wall, i) || off > nearest) continue;
    nearest = off;
    opening.segment = i;
    opening.at_m = at;
    found = true;
  }
  if (!found)
    map.problem("at", "the opening is not on the wall: give the point [x, y] of its middle on the path");
}

void check_opening(YamlMap& map, const WallParams& wall, const Opening& opening) {
  const double half = opening.width_m / 2;
  if (opening.at_m - half < 0.01 || opening.at_m + half > segment_length_m(wall, opening.segment) - 0.01)
    map.problem("width",
                "the opening reaches over an end of its section of wall: move it or make it narrower");
  if (opening.top_m > wall.height_m || opening.sill_m >= opening.top_m)
    map.problem("top", "the opening must lie between `sill` and the wall's height: lower `top` or `sill`");
  for (const Opening& other : wall.openings)
    if (other.segment == opening.segment && std::abs(other.at_m - opening.at_m) < half + other.width_m / 2)
      map.problem("at", "the opening overlaps another one of this wall: move it");
}

struct Copies {
  int count{1};
  Eigen::Vector2d step_m{Eigen::Vector2d::Zero()};
};

Copies read_copies(YamlMap& map) {
  Copies copies;
  YamlMap section = map.section("copies");
  if (!map.has("copies")) return copies;
  copies.count = section.integer("count", 1, kMaxCopies);
  copies.step_m = section.vector2("step", kAny);
  section.refuse_unknown();
  return copies;
}

std::string colour_suffix(const YamlMap& map) {
  const auto* colour = map.find("colour");
  if (colour == nullptr || !colour->value.IsScalar()) return "";
  const std::string& text = colour->value.Scalar();
  return text.empty() || text[0] == '#' ? "" : "_" + text;
}

}  // namespace

std::vector<Eigen::Vector2d> points_of(YamlMap& map, const std::string& key, std::size_t min_count) {
  std::vector<Eigen::Vector2d> points;
  for (const auto& row : map.rows(key, 2, kAny, min_count)) points.emplace_back(row[0], row[1]);
  return points;
}

void ObjectReader::read(YamlMap& world) {
  materials_.read_own(world);
  read_list(world, {});
}

void ObjectReader::read_list(YamlMap& owner, const Group& group) {
  for (YamlMap& entry : owner.maps("objects")) {
    if (objects_.size() >= kMaxObjects) {
      entry.problem("", "more than 5000 objects: make the world smaller");
      return;
    }
    if (entry.items().size() != 1) {
      entry.problem(
          "", "must be one object like `table: {at: [1, 0], ...}`: put one kind in each item of the list");
      continue;
    }
    const std::string& kind = entry.items().front().key;
    YamlMap map = entry.section(kind);
    read_object(kind, map, group);
  }
}

void ObjectReader::read_object(const std::string& kind, YamlMap& map, const Group& group) {
  if (kind == "group") return read_group(map, group);
  if (kind == "wall") return read_wall(map, group);
  if (kind == "floor" || kind == "ceiling") {
    read_slab(map, group, kind == "ceiling");
  } else if (kind == "door") {
    const Eigen::Vector3d at = place_of(map);
    const Pose opening = upright(at.x(), at.y(), at.z(), map.number("yaw_deg", kAny, 0) * kDegree);
    DoorParams params;
    params.width_m = map.number("width", {0.3, 5}, params.width_m);
    params.height_m = map.number("height", {0.3, 5}, params.height_m);
    read_door(map, group.world_T_group * opening, params, group);
  } else if (auto model = read_object_model(kind, map, materials_)) {
    read_placed(map, group, std::move(*model), kind + colour_suffix(map));
  } else {
    auto kinds = object_kinds();
    for (const char* more : {"group", "wall", "floor", "ceiling", "door"}) kinds.emplace_back(more);
    map.problem("", "unknown kind of object \"" + kind + "\"" + hint_for(kind, kinds) +
                        ": config/worlds/README.md lists them");
    return;
  }
  map.refuse_unknown();
}

void ObjectReader::read_group(YamlMap& map, const Group& group) {
  Group inner = group;
  inner.prefix = name_of(map, group, "group") + "_";
  const Eigen::Vector3d at = place_of(map);
  inner.world_T_group =
      group.world_T_group * upright(at.x(), at.y(), at.z(), map.number("yaw_deg", kAny, 0) * kDegree);
  map.expect("objects");
  map.refuse_unknown();
  if (++inner.depth > kDeepest)
    map.problem("objects", "groups within groups are too deep: does this one hold itself?");
  else
    read_list(map, inner);
}

void ObjectReader::read_slab(YamlMap& map, const Group& group, bool ceiling) {
  const Eigen::Vector2d size = map.vector2("size", kLength, Eigen::Vector2d(max_m_ - min_m_));
  const Eigen::Vector2d middle = map.vector2("at", kAny, Eigen::Vector2d((min_m_ + max_m_) / 2));
  const double thick = 0.1;
  const double z = ceiling ? map.number("height", {0.1, 100}, 2.6) : -thick;
  ObjectModel model;
  const Material material = materials_.read(map, ceiling ? "plaster" : "tiles");
  add(model, Box{{size.x(), size.y(), thick}}, {0, 0, thick / 2}, material);
  const std::string name = name_of(map, group, ceiling ? "ceiling" : "floor");
  keep(map, model, name, group.world_T_group * upright(middle.x(), middle.y(), z, 0));
}

void ObjectReader::read_wall(YamlMap& map, const Group& group) {
  WallParams wall;
  wall.closed = map.flag("closed", false);
  wall.path_m = points_of(map, "path", wall.closed ? 3 : 2);
  wall.height_m = map.number("height", {0.05, 20}, wall.height_m);
  wall.thickness_m = map.number("thickness", {0.01, 2}, wall.thickness_m);
  wall.skirting = map.flag("skirting", wall.skirting);
  const Material material = materials_.read(map, "plaster");
  const std::string name = name_of(map, group, "wall");
  auto openings = map.maps("openings");
  map.refuse_unknown();
  if (wall.path_m.size() < 2) return;
  for (std::size_t i = 0; i < segment_count(wall); ++i)
    if (segment_length_m(wall, i) < wall.thickness_m)
      map.problem("path",
                  "section " + std::to_string(i + 1) + " is shorter than the wall is thick: remove a point");
  for (YamlMap& opening : openings) {
    read_opening(opening, wall);
    read_opening_door(opening, wall, group);
    opening.refuse_unknown();
  }
  keep(map, walls(wall, material), name, group.world_T_group, "", false);
}

void ObjectReader::read_opening(YamlMap& map, WallParams& wall) {
  Opening opening;
  opening.width_m = map.number("width", {0.05, 100}, opening.width_m);
  opening.sill_m = map.number("sill", {0, 20}, opening.sill_m);
  opening.top_m = map.number("top", {0.05, 20}, std::min(opening.top_m, wall.height_m));
  locate_opening(map, wall, map.vector2("at", kAny), opening);
  check_opening(map, wall, opening);
  wall.openings.push_back(opening);
}

void ObjectReader::read_opening_door(YamlMap& opening, const WallParams& wall, const Group& group) {
  YamlMap map = opening.section("door");
  if (!opening.has("door")) return;
  DoorParams params;
  params.width_m = wall.openings.back().width_m;
  params.height_m = wall.openings.back().top_m;
  read_door(map, group.world_T_group * opening_pose(wall, wall.openings.back()), params, group);
  map.refuse_unknown();
}

void ObjectReader::read_door(YamlMap& map, const Pose& world_T_opening, DoorParams params,
                             const Group& group) {
  params.hinge_right = map.choice("hinge", {"left", "right"}) == 1;
  const double open = map.number("open_deg", {-170, 170}, 0) * kDegree;
  const Material material = materials_.read(map, "pine");
  const std::string name = name_of(map, group, "door");
  keep(map, door(params, material), name, world_T_opening * door_pose(params, open));
}

void ObjectReader::read_placed(YamlMap& map, const Group& group, ObjectModel model, const std::string& kind) {
  read_body_keys(map, model);
  const Eigen::Vector3d at = place_of(map);
  const double yaw = map.number("yaw_deg", kAny, 0) * kDegree;
  const Support under = support(map, group);
  const Copies copies = read_copies(map);
  const std::string name = name_of(map, group, kind);
  for (int i = 0; i < copies.count; ++i) {
    const Eigen::Vector2d point = at.head<2>() + i * copies.step_m;
    Pose pose = group.world_T_group * upright(point.x(), point.y(), at.z(), yaw);
    if (!under.name.empty()) rest_on(map, under, pose);
    keep(map, model, copies.count > 1 ? name + "_" + std::to_string(i + 1) : name, pose, under.name);
  }
}

void ObjectReader::rest_on(YamlMap& map, const Support& support, Pose& world_T_object) const {
  const Eigen::Vector3d local = support.world_T_support.inverse() * world_T_object.translation();
  const Eigen::Vector2d off = (local.head<2>() - support.surface.centre_m).cwiseAbs();
  if ((off - support.surface.half_m).maxCoeff() > 0)
    map.problem("at", "is not above \"" + support.name + "\": choose a point on it, or remove `on`");
  world_T_object.translation().z() = support.world_T_support.translation().z() + support.surface.z_m;
}

ObjectReader::Support ObjectReader::support(YamlMap& map, const Group& group) const {
  const std::string on = map.text("on", "");
  const int level = map.integer("level", 1, 20, 1);
  if (on.empty()) return {};
  const PlacedObject* under = find(group.prefix + on);
  if (under == nullptr) under = find(on);
  if (under == nullptr) {
    map.problem("on", "there is no object \"" + on + "\" above this line: name one that stands earlier");
    return {};
  }
  const auto& surfaces = under->surfaces;
  if (static_cast<std::size_t>(level) <= surfaces.size())
    return {under->body.name, under->world_T_object, surfaces[static_cast<std::size_t>(level - 1)]};
  map.problem(surfaces.empty() ? "on" : "level", "\"" + under->body.name + "\" has " +
                                                     std::to_string(surfaces.size()) +
                                                     " places to stand on: choose another level or object");
  return {};
}

void ObjectReader::keep(const YamlMap& map, const ObjectModel& model, const std::string& name,
                        const Pose& world_T_object, const std::string& on, bool bounded) {
  if (const PlacedObject* other = find(name))
    problems_->add(map.line("name"), map.path() + ".name",
                   "there are two objects \"" + name + "\" (the other one at line " +
                       std::to_string(other->origin.line) + "): give them different names");
  index_by_name_.emplace(name, objects_.size());
  objects_.push_back({place(model, name, world_T_object), world_T_object, model.surfaces,
                      Origin{map.line(), map.path()}, on, bounded});
}

std::string ObjectReader::name_of(YamlMap& map, const Group& group, const std::string& kind) {
  if (map.has("name")) return group.prefix + map.text("name");
  map.expect("name");
  const std::string base = group.prefix + kind;
  std::string name;
  do name = base + "_" + std::to_string(++running_numbers_[base]);
  while (find(name) != nullptr);
  return name;
}

const PlacedObject* ObjectReader::find(const std::string& name) const {
  const auto found = index_by_name_.find(name);
  return found == index_by_name_.end() ? nullptr : &objects_[found->second];
}

}  // namespace extperfc::simulate
