#include "extperfc/arm/depth_obstacles.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "arm/perception/voxel_memory.hpp"

namespace extperfc::arm {
namespace {

constexpr double kMaxVoxels = 8e6;

struct Range {
  const char* name;
  double value, low, high;
};

VoxelGrid grid_of(const DepthObstaclesParams& params) {
  const Eigen::Array3d count =
      ((params.high_m - params.low_m) / params.voxel_m - Eigen::Vector3d::Constant(1e-9))
          .array()
          .ceil()
          .max(1);
  return {params.low_m, params.voxel_m, count.matrix().cast<int>()};
}

Result<void> check(const ImageView& depth, const CameraModel& camera, const Pose& root_T_camera,
                   const JointVector& positions, int joints, double time_s) {
  if (depth.empty() || !is_depth(depth.format))
    return fail(ErrorCode::kInvalidArgument, "not a depth image: 16UC1 [mm] or 32FC1 [m] is needed");
  if (auto ok = camera.validate(); !ok) return ok;
  if (depth.width != camera.width || depth.height != camera.height)
    return fail(ErrorCode::kInvalidArgument,
                "the depth image is " + std::to_string(depth.width) + " x " + std::to_string(depth.height) +
                    ", the camera " + std::to_string(camera.width) + " x " + std::to_string(camera.height));
  if (!root_T_camera.matrix().allFinite() || !root_T_camera.linear().isUnitary(1e-6))
    return fail(ErrorCode::kInvalidArgument, "the camera's pose is no finite rigid transform");
  if (positions.size() != joints || !positions.allFinite())
    return fail(ErrorCode::kInvalidArgument,
                "there must be " + std::to_string(joints) + " finite joint positions");
  if (!std::isfinite(time_s)) return fail(ErrorCode::kInvalidArgument, "the time is not finite");
  return {};
}

}  // namespace

Result<void> DepthObstaclesParams::validate() const {
  const std::array<Range, 10> ranges{{{"voxel_m", voxel_m, 0.005, 0.2},
                                      {"pixel_step", static_cast<double>(pixel_step), 1, 16},
                                      {"min_depth_m", min_depth_m, 0.01, 10},
                                      {"max_depth_m", max_depth_m, min_depth_m + 1e-3, 20},
                                      {"min_points", static_cast<double>(min_points), 1, 1000},
                                      {"robot_padding_m", robot_padding_m, 0, 0.3},
                                      {"object_padding_m", object_padding_m, 0, 0.3},
                                      {"clear_margin_m", clear_margin_m, 0, 0.5},
                                      {"max_age_s", max_age_s, 0.05, 3600},
                                      {"max_boxes", static_cast<double>(max_boxes), 8, 5000}}};
  for (const Range& range : ranges)
    if (!(range.value >= range.low && range.value <= range.high))
      return fail(ErrorCode::kInvalidArgument,
                  std::string(range.name) + " is " + std::to_string(range.value) + ", it must be from " +
                      std::to_string(range.low) + " to " + std::to_string(range.high));
  if (!low_m.allFinite() || !high_m.allFinite() || !((high_m - low_m).minCoeff() > 0))
    return fail(ErrorCode::kInvalidArgument, "low_m must be below high_m on every axis");
  if (!(((high_m - low_m) / voxel_m).array().ceil().prod() <= kMaxVoxels))
    return fail(ErrorCode::kInvalidArgument, "more than 8 million voxels: a smaller box or larger voxels");
  if (name.empty()) return fail(ErrorCode::kInvalidArgument, "the object needs a name");
  return {};
}

Result<DepthObstacles> DepthObstacles::make(const CollisionModel& model, const DepthObstaclesParams& params) {
  if (auto ok = params.validate(); !ok) return tl::unexpected<Error>(ok.error());
  return DepthObstacles(std::make_unique<VoxelMemory>(model, params, grid_of(params)));
}

DepthObstacles::DepthObstacles(std::unique_ptr<VoxelMemory> memory) : memory_(std::move(memory)) {}
DepthObstacles::DepthObstacles(DepthObstacles&&) noexcept = default;
DepthObstacles& DepthObstacles::operator=(DepthObstacles&&) noexcept = default;
DepthObstacles::~DepthObstacles() = default;

Result<DepthUpdate> DepthObstacles::update(const ImageView& depth, const CameraModel& camera,
                                           const Pose& root_T_camera, const JointVector& positions,
                                           const CollisionWorld& known, double time_s) {
  const DepthObstaclesParams& params = memory_->params;
  if (auto ok = check(depth, camera, root_T_camera, positions, memory_->model.joint_count(), time_s); !ok)
    return tl::unexpected<Error>(ok.error());
  auto parts = mask_parts(memory_->model.bodies(), positions, known, params.name, params.robot_padding_m,
                          params.object_padding_m);
  if (!parts) return tl::unexpected<Error>(parts.error());
  return memory_->update({depth, camera, root_T_camera}, std::move(*parts), time_s);
}

bool DepthObstacles::forget(const CollisionWorld& known) {
  return memory_->forget(object_parts(known, memory_->params.name, memory_->params.object_padding_m));
}

const std::optional<WorldObject>& DepthObstacles::object() const {
  return memory_->object;
}

std::vector<Eigen::Vector3d> DepthObstacles::voxels() const {
  std::vector<Eigen::Vector3d> middles;
  for (const auto& voxel : memory_->voxels)
    middles.push_back(memory_->grid.centre(memory_->grid.cell(voxel.index)));
  return middles;
}

void DepthObstacles::clear() {
  memory_->clear();
}

}  // namespace extperfc::arm
