#include "simulate/worlds/object_model_reader.hpp"

#include <map>

#include "simulate/worlds/furniture.hpp"
#include "simulate/worlds/objects.hpp"

namespace extperfc::simulate {

namespace {

using Reader = ObjectModel (*)(YamlMap&, const MaterialReader&);
using Readers = std::map<std::string, Reader>;

std::uint64_t seed_of(YamlMap& map) {
  return static_cast<std::uint64_t>(map.integer("seed", 0, 1000000, 1));
}

Eigen::Vector3d size_of(YamlMap& map, const std::optional<Eigen::Vector3d>& fallback = {}) {
  return map.vector3("size", kLength, fallback);
}

double diameter_of(YamlMap& map, double fallback) {
  return map.number("diameter", kLength, fallback);
}

double height_of(YamlMap& map, double fallback) {
  return map.number("height", kLength, fallback);
}

/// A plain shape: fixed unless its `mobility` says otherwise, without a mass.
ObjectModel plain(ObjectModel model) {
  model.mobility = Mobility::kFixed;
  model.mass_kg = 0;
  model.label.clear();
  return model;
}

ObjectModel read_shelf(YamlMap& map, const MaterialReader& materials) {
  ShelfParams params;
  params.size_m = size_of(map, params.size_m);
  params.levels = map.integer("levels", 1, 20, params.levels);
  params.filled = map.number("books", kFraction, params.filled);
  params.empty_level = map.integer("books_up_to", 0, 20, params.levels);
  params.seed = seed_of(map);
  return shelf(params, materials.read(map, "oak"));
}

const Readers& furniture_readers() {
  static const Readers readers{
      {"table",
       [](YamlMap& map, const MaterialReader& materials) {
         const Material legs = materials.read_named(map, "leg_material", "dark_metal");
         return table(size_of(map), materials.read(map, "oak"), legs);
       }},
      {"desk",
       [](YamlMap& map, const MaterialReader& materials) {
         const Material body = materials.read_named(map, "body_material", "white");
         return desk(size_of(map, Eigen::Vector3d{0.8, 1.6, 0.73}), materials.read(map, "pine"), body);
       }},
      {"chair",
       [](YamlMap& map, const MaterialReader& materials) {
         return chair(height_of(map, 0.45), materials.read(map, "pine"));
       }},
      {"office_chair",
       [](YamlMap& map, const MaterialReader& materials) {
         return office_chair(height_of(map, 0.48), materials.read(map, "cloth"));
       }},
      {"sofa",
       [](YamlMap& map, const MaterialReader& materials) {
         return sofa(size_of(map, Eigen::Vector3d{0.9, 1.9, 0.8}), materials.read(map, "cloth"));
       }},
      {"stool",
       [](YamlMap& map, const MaterialReader& materials) {
         return stool(height_of(map, 0.45), materials.read(map, "pine"));
       }},
      {"shelf", read_shelf},
      {"cabinet",
       [](YamlMap& map, const MaterialReader& materials) {
         const int drawers = map.integer("drawers", 1, 12, 3);
         return cabinet(size_of(map, Eigen::Vector3d{0.45, 0.8, 1.1}), materials.read(map, "white"), drawers);
       }},
      {"plant", [](YamlMap& map,
                   const MaterialReader& /*materials*/) { return plant(height_of(map, 1.2), seed_of(map)); }},
      {"screen",
       [](YamlMap& map, const MaterialReader& /*materials*/) {
         return screen(map.number("width", kLength, 0.55));
       }},
      {"keyboard", [](YamlMap& /*map*/, const MaterialReader& /*materials*/) { return keyboard(); }},
      {"desk_lamp",
       [](YamlMap& map, const MaterialReader& materials) {
         return desk_lamp(materials.read(map, "dark_metal"));
       }},
      {"bin",
       [](YamlMap& map, const MaterialReader& materials) {
         return waste_bin(height_of(map, 0.35), materials.read(map, "dark_metal"));
       }},
      {"pillar",
       [](YamlMap& map, const MaterialReader& materials) {
         return pillar(diameter_of(map, 0.4) / 2, height_of(map, 2.6), materials.read(map, "plaster"));
       }},
  };
  return readers;
}

const Readers& panel_readers() {
  static const Readers readers{
      {"painting",
       [](YamlMap& map, const MaterialReader& /*materials*/) {
         const Eigen::Vector2d size = map.vector2("size", kLength, Eigen::Vector2d{0.8, 0.6});
         return painting(size.x(), size.y(), seed_of(map));
       }},
      {"window",
       [](YamlMap& map, const MaterialReader& /*materials*/) {
         const Eigen::Vector2d size = map.vector2("size", kLength, Eigen::Vector2d{1.4, 1.2});
         return window(size.x(), size.y());
       }},
      {"whiteboard",
       [](YamlMap& map, const MaterialReader& /*materials*/) {
         const Eigen::Vector2d size = map.vector2("size", kLength, Eigen::Vector2d{1.8, 1.1});
         return whiteboard(size.x(), size.y(), seed_of(map));
       }},
      {"rug",
       [](YamlMap& map, const MaterialReader& materials) {
         const Eigen::Vector2d size = map.vector2("size", kLength);
         return plain(block({size.x(), size.y(), 0.008}, materials.read(map, "carpet")));
       }},
      {"box",
       [](YamlMap& map, const MaterialReader& materials) {
         return plain(block(size_of(map), materials.read(map, "carton")));
       }},
      {"cylinder",
       [](YamlMap& map, const MaterialReader& materials) {
         const double diameter = map.number("diameter", kLength);
         return plain(cylinder(diameter, map.number("height", kLength), materials.read(map, "plain")));
       }},
  };
  return readers;
}

const Readers& object_readers() {
  static const Readers readers{
      {"cone",
       [](YamlMap& map, const MaterialReader& materials) {
         const double diameter = map.number("diameter", kLength);
         const double height = height_of(map, 1.3 * diameter);
         const bool lying = map.flag("lying", false);
         const Material material = materials.read(map, "plain");
         return lying ? lying_cone(diameter, height, material) : cone(diameter, height, material);
       }},
      {"cube",
       [](YamlMap& map, const MaterialReader& materials) {
         return cube(map.number("size", kLength), materials.read(map, "plain"));
       }},
      {"sphere",
       [](YamlMap& map, const MaterialReader& materials) {
         return sphere(map.number("diameter", kLength), materials.read(map, "plain"));
       }},
      {"block",
       [](YamlMap& map, const MaterialReader& materials) {
         return block(size_of(map), materials.read(map, "pine"));
       }},
      {"can",
       [](YamlMap& map, const MaterialReader& materials) {
         return can(diameter_of(map, 0.066), height_of(map, 0.115), materials.read(map, "plain"));
       }},
      {"roll",
       [](YamlMap& map, const MaterialReader& materials) {
         return roll(diameter_of(map, 0.05), map.number("length", kLength, 0.12),
                     materials.read(map, "plain"));
       }},
      {"bottle",
       [](YamlMap& map, const MaterialReader& materials) {
         return bottle(height_of(map, 0.25), materials.read(map, "plain"));
       }},
      {"cup",
       [](YamlMap& map, const MaterialReader& materials) {
         return cup(height_of(map, 0.095), materials.read(map, "plain"));
       }},
      {"book",
       [](YamlMap& map, const MaterialReader& materials) {
         return book(size_of(map, Eigen::Vector3d{0.21, 0.15, 0.025}), materials.read(map, "plain"));
       }},
      {"standing_book",
       [](YamlMap& map, const MaterialReader& materials) {
         return standing_book(size_of(map, Eigen::Vector3d{0.15, 0.03, 0.21}), materials.read(map, "plain"));
       }},
      {"step_pyramid",
       [](YamlMap& map, const MaterialReader& materials) {
         return step_pyramid(map.number("size", kLength, 0.08), height_of(map, 0.06),
                             materials.read(map, "plain"));
       }},
  };
  return readers;
}

}  // namespace

std::optional<ObjectModel> read_object_model(const std::string& kind, YamlMap& map,
                                             const MaterialReader& materials) {
  for (const Readers* readers : {&furniture_readers(), &panel_readers(), &object_readers()}) {
    const auto found = readers->find(kind);
    if (found != readers->end()) return found->second(map, materials);
  }
  return std::nullopt;
}

std::vector<std::string> object_kinds() {
  std::vector<std::string> kinds;
  for (const Readers* readers : {&furniture_readers(), &panel_readers(), &object_readers()})
    for (const auto& [kind, reader] : *readers) kinds.push_back(kind);
  return kinds;
}

}  // namespace extperfc::simulate
