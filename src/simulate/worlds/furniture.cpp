#include "simulate/worlds/furniture.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/base/rng.hpp"

#include "simulate/worlds/materials.hpp"

namespace extperfc::simulate {

namespace {

Material paint(float red, float green, float blue, float gloss = 0.05F) {
  return {{red, green, blue}, Texture::kNone, 1.0F, gloss};
}

void add_box(ObjectModel& model, const Eigen::Vector3d& size, const Eigen::Vector3d& centre,
             const Material& material) {
  add(model, Box{size}, centre, material);
}

/// Four square legs under a plate of this size.
void add_legs(ObjectModel& model, double depth, double width, double height, double thick,
              const Material& legs) {
  const double x = depth / 2 - thick / 2 - 0.01;
  const double y = width / 2 - thick / 2 - 0.01;
  for (const double side_x : {-x, x})
    for (const double side_y : {-y, y})
      add_box(model, {thick, thick, height}, {side_x, side_y, height / 2}, legs);
}

/// Fronts of drawers or doors with handles, stacked on the front of a block.
void add_fronts(ObjectModel& model, const Eigen::Vector3d& size, const Eigen::Vector3d& centre, int drawers,
                const Material& material) {
  const double gap = 0.006;
  const double each = size.z() / drawers;
  const double front = centre.x() + size.x() / 2;
  for (int i = 0; i < drawers; ++i) {
    const double z = centre.z() - size.z() / 2 + each * (i + 0.5);
    add_box(model, {0.014, size.y() - gap, each - gap}, {front + 0.007, centre.y(), z},
            shaded(material, 1.06F));
    add_box(model, {0.02, std::min(0.14, size.y() / 3), 0.014},
            {front + 0.024, centre.y(), z + std::min(0.05, each / 4)}, known_materials().at("metal"));
  }
}

/// Runs of books on one board: blocks of one height each, with gaps.
void add_books(ObjectModel& model, const ShelfParams& params, double z, double clear, Rng& rng) {
  const double end = params.size_m.y() / 2 - 0.03;
  double y = -end;
  while (y < end - 0.05) {
    const double length = std::min(end - y, rng.uniform(0.08, 0.34));
    if (rng.chance(params.filled)) {
      const double height = std::min(clear * 0.92, rng.uniform(0.18, 0.27));
      const double depth = params.size_m.x() * rng.uniform(0.55, 0.75);
      const auto tint = [&rng] { return static_cast<float>(rng.uniform(0.55, 1.0)); };
      const Material spines{{tint(), tint(), tint()}, Texture::kBooks, 0.5F, 0.05F};
      add_box(model, {depth, length, height},
              {params.size_m.x() / 2 - 0.02 - depth / 2, y + length / 2, z + height / 2}, spines);
      y += length + 0.002;
    } else {
      y += length * 0.6;
    }
  }
}

}  // namespace

ObjectModel table(const Eigen::Vector3d& size_m, const Material& top, const Material& legs) {
  ObjectModel model;
  const double thick = std::min(0.035, size_m.z() / 3);
  add_box(model, {size_m.x(), size_m.y(), thick}, {0, 0, size_m.z() - thick / 2}, top);
  add_legs(model, size_m.x(), size_m.y(), size_m.z() - thick, std::min(0.05, size_m.x() / 6), legs);
  model.surfaces.push_back({size_m.z(), size_m.head<2>() / 2});
  return model;
}

ObjectModel desk(const Eigen::Vector3d& size_m, const Material& top, const Material& body) {
  ObjectModel model;
  const double under = size_m.z() - 0.03;
  add_box(model, {size_m.x(), size_m.y(), 0.03}, {0, 0, size_m.z() - 0.015}, top);
  const Eigen::Vector3d drawers(size_m.x() - 0.12, 0.4, under - 0.06);
  const Eigen::Vector3d centre(-0.02, size_m.y() / 2 - 0.23, under - drawers.z() / 2);
  // One sits at -x, so the drawers open to there: they are built to the front and turned round.
  ObjectModel block;
  add_box(block, drawers, centre, body);
  add_fronts(block, drawers, centre, 3, body);
  const Pose rotation = make_pose(Eigen::Vector3d::Zero(), {0, 0, 2 * kRightAngle});
  for (const Shape& shape : block.shapes)
    add(model, shape.geometry, rotation * shape.body_T_shape, shape.material);
  for (const double x : {-1.0, 1.0})
    add_box(model, {0.05, 0.05, under}, {x * (size_m.x() / 2 - 0.04), size_m.y() / 2 - 0.04, under / 2},
            body);
  add_box(model, {0.02, size_m.y() - 0.5, under * 0.5}, {size_m.x() / 2 - 0.03, 0.2, under * 0.7}, body);
  model.surfaces.push_back({size_m.z(), size_m.head<2>() / 2});
  return model;
}

ObjectModel chair(double seat_m, const Material& material) {
  ObjectModel model;
  model.mobility = Mobility::kMovable;
  const Material legs = shaded(material, 0.7F);
  add_legs(model, 0.42, 0.42, seat_m - 0.03, 0.035, legs);
  add_box(model, {0.42, 0.42, 0.03}, {0, 0, seat_m - 0.015}, material);
  for (const double y : {-0.18, 0.18}) add_box(model, {0.03, 0.035, 0.45}, {-0.19, y, seat_m + 0.225}, legs);
  for (const double z : {0.2, 0.38}) add_box(model, {0.025, 0.36, 0.11}, {-0.19, 0, seat_m + z}, material);
  model.surfaces.push_back({seat_m, {0.21, 0.21}});
  return model;
}

ObjectModel office_chair(double seat_m, const Material& cushion) {
  ObjectModel model;
  model.mobility = Mobility::kMovable;
  const Material& metal = known_materials().at("dark_metal");
  for (int i = 0; i < 5; ++i) {
    const double angle = 4 * kRightAngle * i / 5;
    const Eigen::Vector2d foot(std::cos(angle), std::sin(angle));
    add(model, Box{{0.28, 0.045, 0.035}}, {0.15 * foot.x(), 0.15 * foot.y(), 0.075}, metal, angle);
    add(model, Box{{0.06, 0.025, 0.06}}, {0.28 * foot.x(), 0.28 * foot.y(), 0.03},
        known_materials().at("black"), angle + 0.4);
  }
  add(model, Cylinder{0.03, seat_m - 0.12}, {0, 0, (seat_m + 0.02) / 2}, metal);
  add_box(model, {0.46, 0.48, 0.07}, {0, 0, seat_m - 0.035}, cushion);
  add_box(model, {0.04, 0.06, 0.25}, {-0.23, 0, seat_m + 0.08}, metal);
  add_box(model, {0.06, 0.44, 0.46}, {-0.21, 0, seat_m + 0.4}, cushion);
  for (const double y : {-0.25, 0.25}) {
    add_box(model, {0.04, 0.03, 0.2}, {-0.05, y, seat_m + 0.06}, metal);
    add_box(model, {0.24, 0.05, 0.03}, {-0.02, y, seat_m + 0.175}, metal);
  }
  return model;
}

ObjectModel sofa(const Eigen::Vector3d& size_m, const Material& material) {
  ObjectModel model;
  const double seat = size_m.z() * 0.5;
  const double arm = 0.16;
  add_box(model, {size_m.x(), size_m.y(), seat - 0.12}, {0, 0, 0.06 + (seat - 0.12) / 2},
          shaded(material, 0.85F));
  const double cushion = (size_m.y() - 2 * arm) / 2;
  for (const double y : {-cushion / 2, cushion / 2}) {
    add_box(model, {size_m.x() - 0.24, cushion - 0.01, 0.12}, {0.11, y, seat}, material);
    add_box(model, {0.16, cushion - 0.02, size_m.z() - seat},
            {-size_m.x() / 2 + 0.26, y, (size_m.z() + seat) / 2}, shaded(material, 1.1F));
  }
  add_box(model, {0.18, size_m.y(), size_m.z() - 0.06}, {-size_m.x() / 2 + 0.09, 0, size_m.z() / 2 + 0.03},
          material);
  for (const double y : {-1.0, 1.0})
    add_box(model, {size_m.x(), arm, seat + 0.12},
            {0, y * (size_m.y() / 2 - arm / 2), 0.06 + (seat + 0.12) / 2}, material);
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      add_box(model, {0.05, 0.05, 0.06}, {x * (size_m.x() / 2 - 0.05), y * (size_m.y() / 2 - 0.05), 0.03},
              known_materials().at("black"));
  return model;
}

ObjectModel stool(double height_m, const Material& material) {
  ObjectModel model;
  model.mobility = Mobility::kMovable;
  add(model, Cylinder{0.17, 0.04}, {0, 0, height_m - 0.02}, material);
  add_legs(model, 0.26, 0.26, height_m - 0.04, 0.03, shaded(material, 0.7F));
  model.surfaces.push_back({height_m, {0.12, 0.12}});
  return model;
}

ObjectModel shelf(const ShelfParams& params, const Material& material) {
  ObjectModel model;
  Rng rng(params.seed);
  const Eigen::Vector3d& size = params.size_m;
  const double board = 0.022;
  const double plinth = 0.05;
  for (const double y : {-1.0, 1.0})
    add_box(model, {size.x(), board, size.z()}, {0, y * (size.y() - board) / 2, size.z() / 2}, material);
  add_box(model, {0.01, size.y() - 2 * board, size.z()}, {-size.x() / 2 + 0.005, 0, size.z() / 2},
          shaded(material, 0.85F));
  add_box(model, {size.x() - 0.02, size.y() - 2 * board, board}, {0.005, 0, size.z() - board / 2}, material);
  add_box(model, {0.015, size.y() - 2 * board, plinth}, {size.x() / 2 - 0.03, 0, plinth / 2}, material);
  const double step = (size.z() - board - plinth) / params.levels;
  for (int level = 0; level < params.levels; ++level) {
    const double z = plinth + step * level + board;
    add_box(model, {size.x() - 0.02, size.y() - 2 * board, board}, {0.005, 0, z - board / 2}, material);
    model.surfaces.push_back({z, {size.x() / 2 - 0.01, size.y() / 2 - board}, {0.005, 0}, step - board});
    if (params.empty_level < 0 || level < params.empty_level) add_books(model, params, z, step - board, rng);
  }
  return model;
}

ObjectModel cabinet(const Eigen::Vector3d& size_m, const Material& material, int drawers) {
  ObjectModel model;
  model.mobility = Mobility::kMovable;
  const double plinth = std::min(0.06, size_m.z() / 5);
  const Eigen::Vector3d block(size_m.x() - 0.034, size_m.y(), size_m.z() - plinth);
  const Eigen::Vector3d centre(-0.017, 0, plinth + block.z() / 2);
  add_box(model, block, centre, material);
  add_box(model, {block.x() - 0.06, size_m.y() - 0.04, plinth}, {-0.03, 0, plinth / 2},
          shaded(material, 0.5F));
  add_fronts(model, block, centre, drawers, material);
  model.surfaces.push_back({size_m.z(), block.head<2>() / 2, centre.head<2>()});
  return model;
}

ObjectModel plant(double height_m, std::uint64_t seed) {
  ObjectModel model;
  model.mobility = Mobility::kMovable;
  Rng rng(seed);
  const double pot = height_m * 0.25;
  const double radius = height_m * 0.15;
  add(model, Cylinder{radius * 0.85, pot}, {0, 0, pot / 2}, paint(0.68F, 0.36F, 0.24F));
  add(model, Cylinder{radius, pot * 0.2}, {0, 0, pot * 0.95}, paint(0.74F, 0.40F, 0.27F));
  add(model, Cylinder{radius * 0.9, 0.01}, {0, 0, pot * 1.05}, paint(0.22F, 0.15F, 0.10F, 0));
  add(model, Cylinder{height_m * 0.02, height_m * 0.45}, {0, 0, pot + height_m * 0.22},
      paint(0.35F, 0.24F, 0.14F));
  const Eigen::Vector3d middle(0, 0, height_m * 0.72);
  for (int i = 0; i < 34; ++i) {
    const double yaw = rng.uniform(0, 4 * kRightAngle);
    const double rise = rng.uniform(-0.5, 1.4);
    const Pose stalk = make_pose(middle, {0, -rise, yaw});
    const Pose leaf =
        stalk * make_pose({height_m * rng.uniform(0.08, 0.2), 0, 0}, {rng.uniform(-0.6, 0.6), 0.3, 0});
    const float green = static_cast<float>(rng.uniform(0.35, 0.6));
    add(model, Box{{height_m * 0.2, height_m * 0.06, 0.006}}, leaf,
        paint(green * 0.4F, green, green * 0.35F));
  }
  return model;
}

ObjectModel screen(double width_m) {
  ObjectModel model;
  const double height = width_m * 0.58;
  const Material& black = known_materials().at("black");
  add(model, Cylinder{0.11, 0.012}, {-0.02, 0, 0.006}, black);
  add_box(model, {0.025, 0.05, 0.16}, {-0.03, 0, 0.09}, black);
  const double z = 0.12 + height / 2;
  add_box(model, {0.03, width_m, height}, {0, 0, z}, black);
  add_box(model, {0.002, width_m - 0.03, height - 0.03}, {0.016, 0, z}, paint(0.16F, 0.32F, 0.52F, 0.4F));
  add_box(model, {0.002, width_m * 0.4, height * 0.55}, {0.0172, width_m * 0.2, z},
          paint(0.90F, 0.91F, 0.92F));
  add_box(model, {0.002, width_m * 0.35, height * 0.4}, {0.0172, -width_m * 0.24, z},
          paint(0.13F, 0.14F, 0.16F));
  return model;
}

ObjectModel keyboard() {
  ObjectModel model;
  add_box(model, {0.14, 0.42, 0.016}, {0, 0, 0.008}, known_materials().at("dark_metal"));
  for (int row = 0; row < 4; ++row)
    add_box(model, {0.024, 0.39, 0.004}, {-0.045 + 0.03 * row, 0, 0.018}, paint(0.12F, 0.12F, 0.13F));
  return model;
}

ObjectModel desk_lamp(const Material& material) {
  ObjectModel model;
  add(model, Cylinder{0.08, 0.02}, {0, 0, 0.01}, material);
  add(model, Cylinder{0.009, 0.34}, {0, 0, 0.19}, known_materials().at("metal"));
  add(model, Cylinder{0.009, 0.22}, make_pose({0.09, 0, 0.38}, {0, 1.2, 0}), known_materials().at("metal"));
  add(model, Cone{0.07, 0.14}, make_pose({0.19, 0, 0.39}, {0, 0.35, 0}), material);
  return model;
}

ObjectModel waste_bin(double height_m, const Material& material) {
  ObjectModel model;
  model.mobility = Mobility::kMovable;
  add(model, Cylinder{height_m * 0.38, height_m}, {0, 0, height_m / 2}, material);
  add(model, Cylinder{height_m * 0.35, 0.004}, {0, 0, height_m + 0.002}, shaded(material, 0.3F));
  return model;
}

ObjectModel pillar(double radius_m, double height_m, const Material& material) {
  ObjectModel model;
  add(model, Cylinder{radius_m, height_m}, {0, 0, height_m / 2}, material);
  return model;
}

ObjectModel painting(double width_m, double height_m, std::uint64_t seed) {
  ObjectModel model;
  Rng rng(seed);
  const Material frame = rng.chance(0.5) ? known_materials().at("black") : known_materials().at("walnut");
  add_box(model, {0.02, width_m, height_m}, {0.01, 0, 0}, frame);
  add_box(model, {0.004, width_m - 0.05, height_m - 0.05}, {0.021, 0, 0}, paint(0.94F, 0.93F, 0.90F));
  for (int i = 0; i < 9; ++i) {
    const auto tint = [&rng] { return static_cast<float>(rng.uniform(0.08, 0.9)); };
    const double wide = rng.uniform(0.08, 0.4) * width_m;
    const double high = rng.uniform(0.08, 0.4) * height_m;
    const double y = rng.uniform(-1, 1) * (width_m / 2 - 0.06 - wide / 2);
    const double z = rng.uniform(-1, 1) * (height_m / 2 - 0.06 - high / 2);
    add_box(model, {0.001, wide, high}, {0.0236 + 0.0006 * i, y, z}, paint(tint(), tint(), tint()));
  }
  return model;
}

ObjectModel window(double width_m, double height_m) {
  ObjectModel model;
  const Material& white = known_materials().at("white");
  add_box(model, {0.012, width_m, height_m}, {0.006, 0, 0}, paint(0.68F, 0.82F, 0.95F, 0.5F));
  add_box(model, {0.002, width_m - 0.02, height_m * 0.3}, {0.0135, 0, -height_m * 0.34},
          paint(0.48F, 0.62F, 0.45F));
  for (const double z : {-0.5, 0.5})
    add_box(model, {0.04, width_m + 0.08, 0.05}, {0.02, 0, z * height_m}, white);
  for (const double y : {-0.5, 0.0, 0.5})
    add_box(model, {0.035, 0.05, height_m}, {0.0175, y * width_m, 0}, white);
  add_box(model, {0.14, width_m + 0.14, 0.025}, {0.07, 0, -height_m / 2 - 0.03}, white);
  return model;
}

ObjectModel whiteboard(double width_m, double height_m, std::uint64_t seed) {
  ObjectModel model;
  Rng rng(seed);
  add_box(model, {0.015, width_m, height_m}, {0.0075, 0, 0}, known_materials().at("metal"));
  add_box(model, {0.004, width_m - 0.04, height_m - 0.04}, {0.016, 0, 0}, paint(0.96F, 0.96F, 0.96F, 0.2F));
  add_box(model, {0.06, width_m * 0.6, 0.015}, {0.03, 0, -height_m / 2 - 0.01},
          known_materials().at("metal"));
  for (int line = 0; line < 6; ++line) {
    const double length = rng.uniform(0.15, 0.6) * width_m;
    const double y = width_m / 2 - 0.08 - length / 2;
    const Material pen = rng.chance(0.7) ? paint(0.12F, 0.14F, 0.35F) : paint(0.72F, 0.12F, 0.12F);
    add_box(model, {0.001, length, 0.012}, {0.0185, y, height_m * (0.34 - 0.12 * line)}, pen);
  }
  return model;
}

}  // namespace extperfc::simulate
