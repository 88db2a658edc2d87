#include "simulate/render/scene.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::simulate {

namespace {

constexpr Placement kHome{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};

Placement placement_of(const Pose& pose) {
  Placement placement{};
  auto out = placement.begin();
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row) *out++ = static_cast<float>(pose.matrix()(row, column));
  return placement;
}

Pose pose_of(const Placement& placement) {
  Pose pose = Pose::Identity();
  auto in = placement.begin();
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row) pose.matrix()(row, column) = *in++;
  return pose;
}

/// Where the snapshot says that a mesh instance is; null when it says nothing.
template <typename Poses>
auto pose_at(const Poses& poses, int index) {
  return static_cast<std::size_t>(index) < poses.size() ? &poses[static_cast<std::size_t>(index)] : nullptr;
}

}  // namespace

Scene::Scene(Stage stage, std::unique_ptr<RayScene> rays) : stage_(std::move(stage)), rays_(std::move(rays)) {
  for (auto& mesh_instance : stage_.mesh_instances) {
    rays_->add(mesh_instance.mesh);
    add_records(mesh_instance.mesh);
    mesh_instance.mesh = {};
    placements_.push_back(kHome);
    frames_.push_back({{1, 0, 0, 0, 1, 0, 0, 0, 1}, false});
  }
  rays_->commit();
}

void Scene::add_records(const Mesh& mesh) {
  first_record_.push_back(static_cast<std::uint32_t>(records_.size()));
  records_.reserve(records_.size() + mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    TriangleRecord record{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& vertex = mesh.vertices[triangle.corners[i]];
      std::copy_n(vertex.normal.data(), 3, record.normal[i]);
      std::copy_n(vertex.texture.data(), 2, record.texture[i]);
    }
    record.surface = triangle.surface;
    records_.push_back(record);
  }
}

bool Scene::place(std::uint32_t mesh_instance, const Pose& world_T_mesh) {
  const Placement placement = placement_of(world_T_mesh);
  if (placement == placements_[mesh_instance]) return false;
  placements_[mesh_instance] = placement;
  std::copy_n(placement.begin(), 9, frames_[mesh_instance].rotation);
  frames_[mesh_instance].rotated = !std::equal(placement.begin(), placement.begin() + 9, kHome.begin());
  rays_->place(mesh_instance, placement);
  return true;
}

void Scene::trail_robot(const Pose& before_T_now) {
  for (std::uint32_t i = 0; i < stage_.mesh_instances.size(); ++i) {
    if (stage_.mesh_instances[i].attached_to != Attachment::kLink) continue;
    const Pose world_T_mesh = pose_of(placements_[i]);
    rays_->place_moving(i, placements_[i], placement_of(before_T_now * world_T_mesh));
  }
  trails_ = true;
  rays_->commit();
}

bool Scene::end_trail() {
  if (!trails_) return false;
  for (std::uint32_t i = 0; i < stage_.mesh_instances.size(); ++i)
    if (stage_.mesh_instances[i].attached_to == Attachment::kLink) rays_->place(i, placements_[i]);
  trails_ = false;
  return true;
}

void Scene::pose(const Snapshot& snapshot) {
  bool moved = end_trail();
  for (std::uint32_t i = 0; i < stage_.mesh_instances.size(); ++i) {
    const auto& mesh_instance = stage_.mesh_instances[i];
    if (mesh_instance.attached_to == Attachment::kLink) {
      if (const auto* pose = pose_at(snapshot.world_T_link, mesh_instance.index)) moved |= place(i, *pose);
    } else if (mesh_instance.attached_to == Attachment::kBody) {
      if (const auto* pose = pose_at(snapshot.world_T_body, mesh_instance.index)) moved |= place(i, *pose);
    } else if (mesh_instance.attached_to == Attachment::kPerson) {
      if (const auto* pose = pose_at(snapshot.world_T_person, mesh_instance.index))
        moved |= place(i, to_pose(*pose));
    }
  }
  if (moved) rays_->commit();
}

}  // namespace extperfc::simulate
