#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/shape.hpp"

namespace extperfc::simulate {

enum class Mobility {
  kFixed,    ///< never moves: floor, wall, table
  kMovable,  ///< moves only when the move service says so: door, box, cabinet
  kLoose,    ///< has a mass: falls, rolls, can be grasped
};

/// An object in a world.
struct BodySpec {
  std::string name;   ///< unique in its world
  std::string label;  ///< class for detection, e.g. "cube"; empty: background
  Mobility mobility{Mobility::kFixed};
  Pose world_T_body{Pose::Identity()};
  std::vector<Shape> shapes;
  double mass_kg{0};  ///< of a loose body, > 0
  double friction{0.8};
  double restitution{0.1};
  double rolling_friction{0.001};
};

/// Seeds of faces are integers in [0, kMaxFaceSeed].
inline constexpr int kMaxFaceSeed = 999'999;

/// Walks along a closed or open path (there and back) at constant speed and looks where it goes; keeps that
/// direction while it waits.
struct PersonSpec {
  std::string name;
  std::vector<Eigen::Vector2d> path_m;  ///< one point: stands still
  double speed_m_s{0.8};
  bool closed{false};
  Eigen::Vector3f colour{0.2F, 0.3F, 0.6F};  ///< of the clothes, sRGB
  /// At the points of the path when it is walked for the first time, >= 0; fewer than points: 0.
  std::vector<double> stands_s{};
  std::optional<int> face{};  ///< seed of the face; empty: derived from the name
};

struct LightSpec {
  Eigen::Vector3d position_m{0, 0, 2.6};    ///< of the light that casts shadows
  float direct{0.55F};                      ///< weight of its light
  float ambient{0.45F};                     ///< light without direction
  Eigen::Vector3f sky{0.75F, 0.82F, 0.9F};  ///< colour where a ray hits nothing, sRGB
};

/// A world is data: what it holds, and where the robot starts.
struct WorldSpec {
  std::string name;
  std::string description;
  std::vector<BodySpec> bodies;
  std::vector<PersonSpec> people;
  LightSpec light;
  Pose2 robot_start;
  Eigen::Vector2d min_m{-5, -5};  ///< corner of the floor plan with the lowest x and y
  Eigen::Vector2d max_m{5, 5};
};

/// Reads and checks a world. One error with a line per problem: file, line, key, remedy.
[[nodiscard]] Result<WorldSpec> load_world(const std::filesystem::path& file);
[[nodiscard]] Result<WorldSpec> parse_world(const std::string& yaml, const std::string& source_name);

/// The world with the people of a YAML file, whose only key is `people`, as in a world's file. Errors as
/// above.
[[nodiscard]] Result<WorldSpec> with_people(WorldSpec world, const std::filesystem::path& file);

}  // namespace extperfc::simulate
