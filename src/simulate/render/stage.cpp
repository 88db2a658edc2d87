#include "simulate/render/stage.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "simulate/render/face_features.hpp"
#include "simulate/render/face_texture.hpp"
#include "simulate/render/person_mesh.hpp"

namespace extperfc::simulate {

namespace {

constexpr std::size_t kMaxInstances = 65'000;

class Builder {
 public:
  Result<void> add_robot(const RobotModel& robot);
  Result<void> add_bodies(const std::vector<BodySpec>& bodies);
  void add_people(const std::vector<PersonSpec>& people);
  std::uint16_t add_instance(Instance instance) {
    stage_.instances.push_back(std::move(instance));
    return static_cast<std::uint16_t>(stage_.instances.size() - 1);
  }
  Stage take() { return std::move(stage_); }

 private:
  std::uint32_t add_surface(const Material& material, const MipTexture* texture, std::uint16_t instance);
  /// The texture of a face, drawn when the first person has it.
  const MipTexture& face_texture(int seed, const FaceFeatures& face);
  void add_person(const PersonSpec& person, int index, const FaceFeatures& face, const MipTexture& texture);
  Result<void> add_shapes(const std::vector<Shape>& shapes, const Pose& mesh_T_body, std::uint16_t instance,
                          Mesh& mesh);

  Stage stage_;
};

float luminance(const std::array<float, 3>& linear) {
  return 0.2126F * linear[0] + 0.7152F * linear[1] + 0.0722F * linear[2];
}

std::uint32_t Builder::add_surface(const Material& material, const MipTexture* texture,
                                   std::uint16_t instance) {
  TriangleSurface surface;
  for (int i = 0; i < 3; ++i) {
    const float c = std::clamp(material.colour[i], 0.0F, 1.0F);
    surface.albedo[static_cast<std::size_t>(i)] = c * c;  // sRGB's curve is close to a square
  }
  surface.gloss = std::clamp(material.gloss, 0.0F, 1.0F);
  if (texture != nullptr) surface.texture = texture->pixels.data();
  surface.pixels_per_m = static_cast<float>(MipTexture::kSize) / std::max(material.texture_size_m, 1e-3F);
  surface.brightness = luminance(surface.albedo) * (texture != nullptr ? texture->brightness : 1.0F);
  surface.instance = instance;
  stage_.surfaces.push_back(surface);
  return static_cast<std::uint32_t>(stage_.surfaces.size() - 1);
}

Result<void> Builder::add_shapes(const std::vector<Shape>& shapes, const Pose& mesh_T_body,
                                 std::uint16_t instance, Mesh& mesh) {
  for (const auto& shape : shapes) {
    const auto part = make_mesh(shape.geometry, shape.material,
                                add_surface(shape.material, texture_of(shape.material.texture), instance));
    if (!part) return tl::unexpected(part.error());
    const Pose mesh_T_shape = mesh_T_body * shape.body_T_shape;
    mesh.append(*part, mesh_T_shape.cast<float>());
  }
  return {};
}

Result<void> Builder::add_robot(const RobotModel& robot) {
  const auto instance = add_instance({"robot", "", -1});
  const auto& links = robot.links();
  // Link that carries each link rigidly, and where it sits on it. Parents come first.
  std::vector<int> carrier(links.size());
  std::vector<Pose> carrier_T_link(links.size(), Pose::Identity());
  std::vector<Mesh> meshes(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    carrier[i] = static_cast<int>(i);
    if (links[i].parent_joint >= 0) {
      const auto& joint = robot.joints()[static_cast<std::size_t>(links[i].parent_joint)];
      const auto parent = static_cast<std::size_t>(joint.parent_link);
      if (joint.type == JointType::kFixed && parent < i) {
        carrier[i] = carrier[parent];
        carrier_T_link[i] = carrier_T_link[parent] * joint.parent_T_joint;
      }
    }
    auto added = add_shapes(links[i].visuals, carrier_T_link[i], instance,
                            meshes[static_cast<std::size_t>(carrier[i])]);
    if (!added) return fail(added.error().code, "link " + links[i].name + ": " + added.error().message);
  }
  for (std::size_t i = 0; i < links.size(); ++i)
    if (!meshes[i].triangles.empty())
      stage_.mesh_instances.push_back({std::move(meshes[i]), Attachment::kLink, static_cast<int>(i)});
  return {};
}

Result<void> Builder::add_bodies(const std::vector<BodySpec>& bodies) {
  MeshInstance fixed;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto& body = bodies[i];
    const auto instance = add_instance({body.name, body.label, static_cast<int>(i)});
    const bool moves = body.mobility != Mobility::kFixed;
    MeshInstance own{{}, Attachment::kBody, static_cast<int>(i)};
    auto added = add_shapes(body.shapes, moves ? Pose::Identity() : body.world_T_body, instance,
                            moves ? own.mesh : fixed.mesh);
    if (!added) return fail(added.error().code, "body " + body.name + ": " + added.error().message);
    if (!own.mesh.triangles.empty()) stage_.mesh_instances.push_back(std::move(own));
  }
  if (!fixed.mesh.triangles.empty()) stage_.mesh_instances.push_back(std::move(fixed));
  return {};
}

const MipTexture& Builder::face_texture(int seed, const FaceFeatures& face) {
  const auto known = stage_.faces.find(seed);
  if (known != stage_.faces.end()) return known->second;
  return stage_.faces.emplace(seed, make_face_texture(face)).first->second;
}

void Builder::add_person(const PersonSpec& person, int index, const FaceFeatures& face,
                         const MipTexture& texture) {
  const auto instance = add_instance({person.name, "person", -1});
  PersonSurfaces surfaces{};
  for (const auto part : kPersonParts) {
    const Material material = person_material(part, person.colour, static_cast<std::uint32_t>(index), face);
    surfaces[static_cast<std::size_t>(part)] =
        add_surface(material, part == PersonPart::kHead ? &texture : texture_of(material.texture), instance);
  }
  stage_.mesh_instances.push_back({make_person(surfaces, face), Attachment::kPerson, index});
}

void Builder::add_people(const std::vector<PersonSpec>& people) {
  for (std::size_t i = 0; i < people.size(); ++i) {
    const int seed = face_seed(people[i]);
    const FaceFeatures face = face_features(seed);
    add_person(people[i], static_cast<int>(i), face, face_texture(seed, face));
  }
}

Result<void> check_faces(const WorldSpec& world) {
  std::set<int> seeds;
  for (const auto& person : world.people) {
    seeds.insert(face_seed(person));
    if (seeds.size() > kMaxFaces)
      return fail(ErrorCode::kUnsupported, "world " + world.name + ", person " + person.name +
                                               ": more than " + std::to_string(kMaxFaces) +
                                               " different faces; give some people the same `face`");
  }
  return {};
}

}  // namespace

Result<Stage> build_stage(const RobotModel& robot, const WorldSpec& world) {
  if (world.bodies.size() + world.people.size() + 2 > kMaxInstances)
    return fail(ErrorCode::kUnsupported, "world " + world.name + " has more than " +
                                             std::to_string(kMaxInstances) +
                                             " bodies and people; leave some out");
  if (auto checked = check_faces(world); !checked) return tl::unexpected(checked.error());
  Builder builder;
  builder.add_instance({"nothing", "", -1});
  if (auto added = builder.add_robot(robot); !added) return tl::unexpected(added.error());
  if (auto added = builder.add_bodies(world.bodies); !added) return tl::unexpected(added.error());
  builder.add_people(world.people);
  return builder.take();
}

}  // namespace extperfc::simulate
