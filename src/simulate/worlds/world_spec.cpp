#include "extperfc/simulate/world_spec.hpp"

#include <optional>

#include "extperfc/base/math.hpp"
#include "extperfc/world/yaml_map.hpp"

#include "simulate/worlds/material_reader.hpp"
#include "simulate/worlds/object_model_reader.hpp"
#include "simulate/worlds/object_reader.hpp"
#include "simulate/worlds/world_checks.hpp"

namespace extperfc::simulate {

namespace {

void read_floor_plan(YamlMap& file, WorldSpec& world) {
  if (!file.has("floor_plan"))
    file.problem("floor_plan", "is missing: add `floor_plan: {min: [x, y], max: [x, y]}` in metres");
  YamlMap map = file.section("floor_plan");
  world.min_m = map.vector2("min", kAny, world.min_m);
  world.max_m = map.vector2("max", kAny, world.max_m);
  map.refuse_unknown();
  if ((world.max_m - world.min_m).minCoeff() <= 0)
    map.problem("max", "must be greater than `min` in x and in y: give the corners of the floor plan");
}

Origin read_robot(YamlMap& file, WorldSpec& world) {
  YamlMap map = file.section("robot");
  const Eigen::Vector2d at = map.vector2("at", kAny, Eigen::Vector2d(0, 0));
  world.robot_start = {at.x(), at.y(), map.number("yaw_deg", kAny, 0) * kDegree};
  map.refuse_unknown();
  return {file.line("robot"), "robot"};
}

void read_light(YamlMap& file, LightSpec& light) {
  YamlMap map = file.section("light");
  light.position_m = map.vector3("at", kAny, light.position_m);
  light.direct = static_cast<float>(map.number("direct", {0, 2}, static_cast<double>(light.direct)));
  light.ambient = static_cast<float>(map.number("ambient", {0, 2}, static_cast<double>(light.ambient)));
  light.sky = read_colour(map, "sky", light.sky);
  map.refuse_unknown();
}

std::vector<Origin> read_people(YamlMap& file, WorldSpec& world) {
  std::vector<Origin> origins;
  for (YamlMap& map : file.maps("people")) {
    PersonSpec person;
    person.name = map.text("name");
    person.path_m = points_of(map, "path", 1);
    person.speed_m_s = map.number("speed", {0.01, 5}, person.speed_m_s);
    person.closed = map.flag("closed", false);
    if (map.has("stands")) person.stands_s = map.numbers("stands", {1, person.path_m.size()}, {0, 1e6});
    person.colour = read_colour(map, "colour", person.colour);
    if (map.has("face")) person.face = map.integer("face", 0, kMaxFaceSeed, 0);
    map.refuse_unknown();
    for (const PersonSpec& other : world.people)
      if (other.name == person.name)
        map.problem("name", "there are two people \"" + person.name + "\": give them different names");
    world.people.push_back(person);
    origins.push_back(Origin{map.line(), map.path()});
  }
  return origins;
}

void check_names(const WorldSpec& world, const std::vector<Origin>& origins, Problems& problems) {
  for (std::size_t i = 0; i < world.people.size(); ++i)
    for (const BodySpec& body : world.bodies)
      if (body.name == world.people[i].name)
        problems.add(origins[i].line, origins[i].key_path + ".name",
                     "an object has the name \"" + body.name + "\" too: give them different names");
}

Result<WorldSpec> read_world(const std::optional<YAML::Node>& root, Problems& problems) {
  if (!root) return tl::unexpected(problems.to_error());
  YamlMap file(*root, "", problems);
  WorldSpec world;
  world.name = file.text("name");
  world.description = file.text("description", "");
  read_floor_plan(file, world);
  const Origin robot = read_robot(file, world);
  read_light(file, world.light);
  const auto people = read_people(file, world);
  file.expect("templates");  // a place for YAML anchors
  ObjectReader reader(problems, world.min_m, world.max_m);
  reader.read(file);
  file.refuse_unknown();
  for (const PlacedObject& object : reader.objects()) world.bodies.push_back(object.body);
  check_names(world, people, problems);
  if (problems.empty()) check_world(world, reader.objects(), robot, people, problems);
  if (!problems.empty()) return tl::unexpected(problems.to_error());
  return world;
}

}  // namespace

Result<WorldSpec> parse_world(const std::string& yaml, const std::string& source_name) {
  Problems problems(source_name);
  return read_world(parse_yaml(yaml, problems), problems);
}

Result<WorldSpec> with_people(WorldSpec world, const std::filesystem::path& file) {
  Problems problems(file.string());
  const auto root = load_yaml(file, problems);
  if (!root) return tl::unexpected(problems.to_error());
  YamlMap map(*root, "", problems);
  const std::size_t before = world.people.size();
  std::vector<Origin> people(before);
  const auto more = read_people(map, world);
  people.insert(people.end(), more.begin(), more.end());
  map.refuse_unknown();
  check_names(world, people, problems);
  if (problems.empty()) check_people(world, before, people, problems);
  if (!problems.empty()) return tl::unexpected(problems.to_error());
  return world;
}

Result<WorldSpec> load_world(const std::filesystem::path& file) {
  Problems problems(file.string());
  return read_world(load_yaml(file, problems), problems);
}

}  // namespace extperfc::simulate
