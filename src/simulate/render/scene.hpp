#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "extperfc/simulate/simulator.hpp"

#include "simulate/render/ray_scene.hpp"
#include "simulate/render/stage.hpp"

namespace extperfc::simulate {

/// What shading needs of a triangle: one cache line.
struct alignas(64) TriangleRecord {
  float normal[3][3];   ///< of the corners, in the mesh instance's frame
  float texture[3][2];  ///< of the corners, repetitions
  std::uint32_t surface;
};
static_assert(sizeof(TriangleRecord) == 64);

/// Rotation of a mesh instance, columns of the matrix.
struct MeshFrame {
  float rotation[9];
  bool rotated;  ///< false: the rotation is the identity
};

/// The stage with everything at its place, ready for rays.
class Scene {
 public:
  Scene(Stage stage, std::unique_ptr<RayScene> rays);

  /// Moves what has another pose than before. A snapshot that lacks a pose leaves the mesh instance where it
  /// was.
  void pose(const Snapshot& snapshot);
  /// Rays of time 0 see the robot where it is, those of time 1 where it was: each link at before_T_now times
  /// its present pose, in the world's frame. A sweep then sees it move with the sensor. Until the next
  /// pose().
  void trail_robot(const Pose& before_T_now);

  [[nodiscard]] const RayScene& rays() const { return *rays_; }
  [[nodiscard]] const std::vector<TriangleSurface>& surfaces() const { return stage_.surfaces; }
  [[nodiscard]] const std::vector<Instance>& instances() const { return stage_.instances; }
  [[nodiscard]] std::size_t triangles() const { return records_.size(); }
  [[nodiscard]] const MeshFrame& frame(std::uint32_t mesh_instance) const { return frames_[mesh_instance]; }
  [[nodiscard]] const TriangleRecord& record(std::uint32_t mesh_instance, std::uint32_t triangle) const {
    return records_[first_record_[mesh_instance] + triangle];
  }

 private:
  void add_records(const Mesh& mesh);
  bool place(std::uint32_t mesh_instance, const Pose& world_T_mesh);
  /// Ends trail_robot(). Returns whether there was one.
  bool end_trail();

  Stage stage_;  ///< without its meshes
  std::unique_ptr<RayScene> rays_;
  std::vector<TriangleRecord> records_;
  std::vector<std::uint32_t> first_record_;
  std::vector<Placement> placements_;
  std::vector<MeshFrame> frames_;
  bool trails_{false};
};

}  // namespace extperfc::simulate
