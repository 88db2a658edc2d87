#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/sensor_rig.hpp"
#include "extperfc/simulate/world_spec.hpp"
#include "extperfc/world/robot_model.hpp"

#include "simulate/render/mesh.hpp"
#include "simulate/render/textures.hpp"

namespace extperfc::simulate {

/// What a ray finds on a triangle.
struct TriangleSurface {
  std::array<float, 3> albedo{};  ///< linear, texture not included
  float gloss{0};
  const std::uint32_t* texture{nullptr};  ///< pixels of a MipTexture; null: none
  float pixels_per_m{0};                  ///< of the texture's level 0
  float brightness{0};                    ///< linear luminance, texture included
  std::uint16_t instance{0};
};

/// What moves a mesh instance.
enum class Attachment { kNone, kLink, kBody, kPerson };

/// Triangles that move together. Fixed bodies are one mesh instance, in world coordinates; links that are
/// joined by fixed joints are one mesh instance, in the frame of the first of them.
struct MeshInstance {
  Mesh mesh;
  Attachment attached_to{Attachment::kNone};
  int index{0};  ///< of the link, body or person
};

/// Different faces of one world: each has a texture of 1.4 MB.
inline constexpr std::size_t kMaxFaces = 64;

/// All that can be seen. Instance 0 is nothing, 1 the robot, then bodies and people in the order of the
/// world.
struct Stage {
  std::vector<MeshInstance> mesh_instances;
  std::vector<TriangleSurface> surfaces;
  std::vector<Instance> instances;
  std::map<int, MipTexture> faces;  ///< by seed, at most kMaxFaces; surfaces point into them
};

/// Errors: a mesh that cannot be read, more than 65,000 instances, more than kMaxFaces different faces.
[[nodiscard]] Result<Stage> build_stage(const RobotModel& robot, const WorldSpec& world);

}  // namespace extperfc::simulate
