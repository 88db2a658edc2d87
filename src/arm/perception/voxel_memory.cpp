#include "arm/perception/voxel_memory.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "arm/perception/box_merge.hpp"

namespace extperfc::arm {
namespace {

constexpr int kLooks = 3;       // rows and columns of pixels that are asked about a voxel
constexpr int kMinAnswers = 3;  // of them that must have a depth

template <PixelFormat kFormat>
float depth_in_row(const std::uint8_t* row, int u);
template <>
float depth_in_row<PixelFormat::kDepth16Mm>(const std::uint8_t* row, int u) {
  const std::uint8_t* const bytes = row + 2 * static_cast<std::size_t>(u);
  return 1e-3F * static_cast<float>(bytes[0] | bytes[1] << 8);
}
template <>
float depth_in_row<PixelFormat::kDepth32M>(const std::uint8_t* row, int u) {
  float metres = 0;
  std::copy_n(row + 4 * static_cast<std::size_t>(u), sizeof metres, reinterpret_cast<std::uint8_t*>(&metres));
  return metres;  // the comparisons with the limits fail for NaN
}

}  // namespace

VoxelMemory::VoxelMemory(const CollisionModel& model_in, const DepthObstaclesParams& params_in,
                         const VoxelGrid& grid_in)
    : model(model_in),
      params(params_in),
      grid(grid_in),
      rays_(params_in.pixel_step),
      mask_(grid_in),
      counts_(grid_in.size(), 0),
      scratch_(grid_in.size(), 0) {}

void VoxelMemory::clear() {
  voxels.clear();
  object.reset();
}

DepthUpdate VoxelMemory::update(const DepthView& view, std::vector<MaskPart> parts, double time_s) {
  DepthUpdate update;
  rays_.set(view.camera);
  mask_.set(std::move(parts));
  if (view.depth.format == PixelFormat::kDepth16Mm)
    count_points<PixelFormat::kDepth16Mm>(view, update);
  else
    count_points<PixelFormat::kDepth32M>(view, update);
  merge(view, time_s, update);
  for (const int voxel : touched_) counts_[voxel] = 0;
  touched_.clear();
  make_object(update);
  return update;
}

bool VoxelMemory::forget(std::vector<MaskPart> parts) {
  mask_.set(std::move(parts));
  const auto kept = std::remove_if(voxels.begin(), voxels.end(),
                                   [&](const Voxel& voxel) { return mask_.covers(voxel.index); });
  if (kept == voxels.end()) return false;
  voxels.erase(kept, voxels.end());
  DepthUpdate unused;
  make_object(unused);
  return true;
}

template <PixelFormat kFormat>
void VoxelMemory::count_points(const DepthView& view, DepthUpdate& update) {
  const Eigen::Matrix3f rotation = view.root_T_camera.linear().cast<float>();
  const Eigen::Vector3f shift = view.root_T_camera.translation().cast<float>();
  const Eigen::Vector3f low = grid.low.cast<float>();
  const auto min_depth = static_cast<float>(params.min_depth_m),
             max_depth = static_cast<float>(params.max_depth_m);
  const float per_metre = 1 / static_cast<float>(grid.edge);
  const Eigen::Vector3f top = grid.count.cast<float>();
  for (int row = 0; row < rays_.rows(); ++row) {
    const std::uint8_t* const pixels = view.depth.row(row * rays_.step());
    const Eigen::Vector2f* const rays = rays_.row(row);
    for (int column = 0; column < rays_.columns(); ++column) {
      const float depth = depth_in_row<kFormat>(pixels, column * rays_.step());
      if (!(depth >= min_depth && depth <= max_depth)) continue;
      const Eigen::Vector2f& ray = rays[column];
      const Eigen::Vector3f point =
          rotation * Eigen::Vector3f(ray.x() * depth, ray.y() * depth, depth) + shift;
      const Eigen::Vector3f at = (point - low) * per_metre;
      if (!(at.x() >= 0 && at.y() >= 0 && at.z() >= 0 && at.x() < top.x() && at.y() < top.y() &&
            at.z() < top.z()))
        continue;
      ++update.points;
      const int voxel =
          grid.index(static_cast<int>(at.x()), static_cast<int>(at.y()), static_cast<int>(at.z()));
      const Owner owner = mask_.owner(voxel, point);
      if (owner != Owner::kNone) {
        ++(owner == Owner::kRobot ? update.robot_points : update.object_points);
        continue;
      }
      std::uint16_t& count = counts_[voxel];
      if (count == 0) touched_.push_back(voxel);
      if (count < std::numeric_limits<std::uint16_t>::max()) ++count;
    }
  }
}

bool VoxelMemory::ends_on_object(const DepthView& view, double u, double v, double depth_m) const {
  const Eigen::Vector3d point = view.root_T_camera * view.camera.back_project(u, v, depth_m);
  const Eigen::Array3d at = (point - grid.low).array() / grid.edge;
  if (!((at >= 0.0).all() && (at < grid.count.cast<double>().array()).all())) return false;
  const Eigen::Array3i cell = at.cast<int>();
  return mask_.owner(grid.index(cell.x(), cell.y(), cell.z()), point.cast<float>()) == Owner::kObject;
}

bool VoxelMemory::seen_empty(const DepthView& view, const Pose& camera_T_root, int voxel) const {
  const Eigen::Vector3d middle = camera_T_root * grid.centre(grid.cell(voxel));
  const double radius = grid.half_diagonal();
  if (middle.z() - radius < params.min_depth_m || !rays_.near_view(middle.head<2>() / middle.z()))
    return false;
  const Eigen::Vector2d pixel = view.camera.project(middle);
  const double reach = radius / middle.z() * view.camera.fx;
  const double far_side = middle.z() + radius;
  const double behind = far_side + params.clear_margin_m;
  int answers = 0;
  for (int i = 0; i < kLooks; ++i)
    for (int k = 0; k < kLooks; ++k) {
      const double u = std::round(pixel.x() + reach * (i - 1)), v = std::round(pixel.y() + reach * (k - 1));
      if (!(u >= 0 && v >= 0 && u < view.depth.width && v < view.depth.height)) continue;
      const double depth = depth_at(view.depth, static_cast<int>(u), static_cast<int>(v));
      if (depth <= 0) continue;
      if (depth < behind && !(depth >= far_side && ends_on_object(view, u, v, depth))) return false;
      ++answers;
    }
  return answers >= kMinAnswers;
}

void VoxelMemory::merge(const DepthView& view, double time_s, DepthUpdate& update) {
  const Pose camera_T_root = view.root_T_camera.inverse();
  std::vector<Voxel> merged;
  for (const int voxel : touched_)
    if (counts_[voxel] >= params.min_points && !mask_.touches_robot(voxel)) merged.push_back({voxel, time_s});
  update.seen = static_cast<int>(merged.size());
  for (const Voxel& old : voxels) {
    if (counts_[old.index] >= params.min_points) continue;
    if (time_s - old.seen_s > params.max_age_s)
      ++update.forgotten;
    else if (mask_.covers(old.index) ||
             (counts_[old.index] == 0 && seen_empty(view, camera_T_root, old.index)))
      ++update.cleared;
    else
      merged.push_back(old);
  }
  std::sort(merged.begin(), merged.end(), [](const Voxel& a, const Voxel& b) { return a.index < b.index; });
  voxels = std::move(merged);
  update.voxels = static_cast<int>(voxels.size());
}

void VoxelMemory::make_object(DepthUpdate& update) {
  std::vector<int> cells;
  cells.reserve(voxels.size());
  for (const Voxel& voxel : voxels) cells.push_back(voxel.index);
  VoxelGrid level = grid;
  std::vector<CellBox> boxes = merge_boxes(level, cells, scratch_);
  while (boxes.size() > static_cast<std::size_t>(params.max_boxes)) {
    cells = coarser_cells(level, cells);
    level = coarser(level);
    boxes = merge_boxes(level, cells, scratch_);
  }
  update.boxes = static_cast<int>(boxes.size());
  update.box_grid_m = level.edge;
  object.reset();
  if (boxes.empty()) return;
  object = WorldObject{params.name, {}, Pose::Identity()};
  object->shapes.reserve(boxes.size());
  for (const CellBox& box : boxes) {
    Shape shape;
    shape.geometry = Box{level.edge * (box.last - box.first + Eigen::Vector3i::Ones()).cast<double>()};
    shape.body_T_shape.translation() = (level.centre(box.first) + level.centre(box.last)) / 2;
    object->shapes.push_back(shape);
  }
}

}  // namespace extperfc::arm
