#include "simulate/worlds/walls.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/base/math.hpp"

#include "simulate/worlds/materials.hpp"

namespace extperfc::simulate {

namespace {
constexpr double kPlay = 0.012;  // between a door and its frame [m]

/// One straight section of wall: its frame at the start on the floor, x along it.
struct Segment {
  Pose start;
  double length{0};
  double begin{0};  ///< where the wall begins and ends along it
  double end{0};
};

Segment segment_of(const WallParams& params, std::size_t index) {
  const std::size_t count = params.path_m.size();
  const Eigen::Vector2d& from = params.path_m[index];
  const Eigen::Vector2d along = params.path_m[(index + 1) % count] - from;
  Segment segment;
  segment.start = upright(from.x(), from.y(), 0, std::atan2(along.y(), along.x()));
  segment.length = along.norm();
  // A corner belongs to the segment that ends there.
  const bool first = !params.closed && index == 0;
  const bool last = !params.closed && index + 1 == segment_count(params);
  segment.begin = first ? 0 : params.thickness_m / 2;
  segment.end = segment.length + (last ? 0 : params.thickness_m / 2);
  return segment;
}

void add_part(ObjectModel& model, const WallParams& params, const Segment& segment, double from, double to,
              double low, double high, const Material& material) {
  if (to - from < 1e-3 || high - low < 1e-3) return;
  const Pose pose = segment.start * upright((from + to) / 2, 0, (low + high) / 2, 0);
  add(model, Box{{to - from, params.thickness_m, high - low}}, pose, material);
  if (!params.skirting || low > 0) return;
  const Pose board = segment.start * upright((from + to) / 2, 0, 0.035, 0);
  add(model, Box{{to - from, params.thickness_m + 0.024, 0.07}}, board, known_materials().at("white"));
}

std::vector<Opening> openings_of(const WallParams& params, std::size_t segment) {
  std::vector<Opening> list;
  for (const Opening& opening : params.openings)
    if (opening.segment == segment) list.push_back(opening);
  std::sort(list.begin(), list.end(), [](const Opening& a, const Opening& b) { return a.at_m < b.at_m; });
  return list;
}

/// White boards around an opening.
void add_frame(ObjectModel& model, const WallParams& params, const Pose& middle, const Opening& opening) {
  const Material& white = known_materials().at("white");
  const double depth = params.thickness_m + 0.03;
  const double high = std::min(opening.top_m, params.height_m) - opening.sill_m;
  const double z = opening.sill_m + high / 2;
  for (const double side : {-0.5, 0.5})
    add(model, Box{{0.05, depth, high}}, middle * upright(side * (opening.width_m + 0.05), 0, z, 0), white);
  add(model, Box{{opening.width_m + 0.1, depth, 0.05}},
      middle * upright(0, 0, opening.sill_m + high + 0.025, 0), white);
}

}  // namespace

std::size_t segment_count(const WallParams& params) {
  return params.path_m.size() - (params.closed ? 0 : 1);
}

double segment_length_m(const WallParams& params, std::size_t segment) {
  return segment_of(params, segment).length;
}

Pose opening_pose(const WallParams& params, const Opening& opening) {
  return segment_of(params, opening.segment).start * upright(opening.at_m, 0, 0, 0);
}

ObjectModel walls(const WallParams& params, const Material& material) {
  ObjectModel model;
  for (std::size_t i = 0; i < segment_count(params); ++i) {
    const Segment segment = segment_of(params, i);
    double from = segment.begin;
    for (const Opening& opening : openings_of(params, i)) {
      const double left = opening.at_m - opening.width_m / 2;
      const double right = opening.at_m + opening.width_m / 2;
      add_part(model, params, segment, from, left, 0, params.height_m, material);
      add_part(model, params, segment, left, right, 0, opening.sill_m, material);
      add_part(model, params, segment, left, right, opening.top_m, params.height_m, material);
      add_frame(model, params, opening_pose(params, opening), opening);
      from = right;
    }
    add_part(model, params, segment, from, segment.end, 0, params.height_m, material);
  }
  return model;
}

ObjectModel door(const DoorParams& params, const Material& material) {
  ObjectModel model;
  model.mobility = Mobility::kMovable;
  const double width = params.width_m - 2 * kPlay;
  const double height = params.height_m - 2 * kPlay;
  const double side = params.hinge_right ? -1 : 1;
  const double middle = side * (kPlay + width / 2);
  add(model, Box{{width, params.thickness_m, height}}, {middle, 0, kPlay + height / 2}, material);
  for (const double z : {0.27, 0.72})  // panels on both faces
    add(model, Box{{width * 0.7, params.thickness_m + 0.008, height * 0.36}}, {middle, 0, height * z},
        shaded(material, 1.12F));
  const Material& metal = known_materials().at("metal");
  const double handle = side * (kPlay + width - 0.07);
  for (const double face : {-1.0, 1.0}) {
    const double off = face * (params.thickness_m / 2 + 0.022);
    add(model, Box{{0.018, 0.044, 0.018}}, {handle, off, 1.02}, metal);
    add(model, Box{{0.12, 0.016, 0.02}}, {handle - side * 0.045, off + face * 0.022, 1.02}, metal);
  }
  return model;
}

Pose door_pose(const DoorParams& params, double open_rad) {
  const double hinge = params.width_m / 2;
  return params.hinge_right ? upright(hinge, 0, 0, -open_rad) : upright(-hinge, 0, 0, open_rad);
}

}  // namespace extperfc::simulate
