#include "simulate/render/scene.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::simulate::render {

namespace {

constexpr Placement kHome{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};

Placement placement_of(const Pose& pose) {
  Placement placement{};
  auto out = placement.begin();
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row) *out++ = static_cast<float>(pose.matrix()(row, column));
  return placement;
}

/// Where the snapshot says that a piece is; null when it says nothing.
template <typename Poses>
auto pose_at(const Poses& poses, int index) {
  return static_cast<std::size_t>(index) < poses.size() ? &poses[static_cast<std::size_t>(index)] : nullptr;
}

}  // namespace

Scene::Scene(Stage stage, std::unique_ptr<RayScene> rays) : stage_(std::move(stage)), rays_(std::move(rays)) {
  for (auto& piece : stage_.pieces) {
    rays_->add(piece.mesh);
    add_records(piece.mesh);
    piece.mesh = {};
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

bool Scene::place(std::uint32_t piece, const Pose& world_T_piece) {
  const Placement placement = placement_of(world_T_piece);
  if (placement == placements_[piece]) return false;
  placements_[piece] = placement;
  std::copy_n(placement.begin(), 9, frames_[piece].rotation);
  frames_[piece].turned = !std::equal(placement.begin(), placement.begin() + 9, kHome.begin());
  rays_->place(piece, placement);
  return true;
}

void Scene::pose(const Snapshot& snapshot) {
  bool moved = false;
  for (std::uint32_t i = 0; i < stage_.pieces.size(); ++i) {
    const auto& piece = stage_.pieces[i];
    if (piece.mover == Mover::kLink) {
      if (const auto* pose = pose_at(snapshot.world_T_link, piece.index)) moved |= place(i, *pose);
    } else if (piece.mover == Mover::kBody) {
      if (const auto* pose = pose_at(snapshot.world_T_body, piece.index)) moved |= place(i, *pose);
    } else if (piece.mover == Mover::kPerson) {
      if (const auto* pose = pose_at(snapshot.world_T_person, piece.index)) moved |= place(i, to_pose(*pose));
    }
  }
  if (moved) rays_->commit();
}

}  // namespace extperfc::simulate::render
