#include "test/benchmark/map/corridor.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::benchmark {
namespace {

using Point = Eigen::Vector2d;

constexpr double kOverlapM = 0.05;  // rectangles of the floor reach into each other
constexpr double kWallM = 0.2;      // between a corridor and its rooms
constexpr double kFreeEndM = 0.5;   // without recesses

/// Builds in coordinates along and across the corridor.
class CorridorBuilder {
 public:
  CorridorBuilder(FloorWorld& floor, const Point& start, const Point& end, const CorridorLook& look, Rng& rng)
      : floor_(floor),
        look_(look),
        rng_(rng),
        along_(std::abs(end.x() - start.x()) > std::abs(end.y() - start.y()) ? 0 : 1),
        middle_(start[1 - along_]),
        from_(std::min(start[along_], end[along_]) + look.width_m / 2),
        to_(std::max(start[along_], end[along_]) - look.width_m / 2) {}

  void build() {
    const double half = look_.width_m / 2;
    floor_.add_floor(place(from_ - look_.width_m, middle_ - half),
                     place(to_ + look_.width_m, middle_ + half));
    for (const double outwards : {-1.0, 1.0}) add_side(middle_ + outwards * half, outwards);
  }

 private:
  [[nodiscard]] Point place(double along, double across) const {
    return along_ == 0 ? Point(along, across) : Point(across, along);
  }

  void add_side(double wall, double outwards) {
    double at = from_ + look_.spacing_m * (look_.regular ? 0.5 : rng_.uniform(0.2, 1.0));
    while (at + look_.door_m + kFreeEndM < to_) {
      const double width = look_.door_m * (look_.regular ? 1.0 : rng_.uniform(0.7, 1.4));
      const double depth = look_.depth_m * (look_.regular ? 1.0 : rng_.uniform(0.6, 1.8));
      if (rng_.chance(look_.room_fraction))
        add_room(at, width, wall, outwards);
      else
        floor_.add_floor(place(at, wall - outwards * kOverlapM), place(at + width, wall + outwards * depth));
      if (rng_.chance(look_.pillar_fraction)) add_pillar(at + width, wall, outwards);
      at += look_.spacing_m * (1 + (look_.jitter > 0 ? rng_.uniform(-look_.jitter, look_.jitter) : 0.0));
    }
  }

  void add_room(double door, double width, double wall, double outwards) {
    floor_.add_floor(place(door, wall - outwards * kOverlapM),
                     place(door + width, wall + outwards * (kWallM + kOverlapM)));
    const double first = door - rng_.uniform(0.3, 1.5);
    const double last = door + width + rng_.uniform(0.3, 2);
    const double depth = rng_.uniform(2.5, 4);
    floor_.add_floor(place(first, wall + outwards * kWallM), place(last, wall + outwards * depth));
  }

  void add_pillar(double behind, double wall, double outwards) {
    const double first = behind + rng_.uniform(0.4, 1.5);
    const double last = first + rng_.uniform(0.2, 0.8);
    if (last < to_) floor_.add_box(place(first, wall), place(last, wall - outwards * rng_.uniform(0.1, 0.3)));
  }

  FloorWorld& floor_;
  const CorridorLook& look_;
  Rng& rng_;
  int along_;      // axis
  double middle_;  // on the other axis
  double from_;    // recesses begin and end here
  double to_;
};

}  // namespace

CorridorLook random_look(CorridorKind kind, double width_m, Rng& rng) {
  CorridorLook look;
  look.width_m = width_m;
  look.spacing_m = rng.uniform(4, 12);
  look.depth_m = rng.uniform(0.1, 0.3);
  look.door_m = rng.uniform(0.9, 1.3);
  look.regular = rng.chance(0.4);
  if (kind == CorridorKind::kSparse) {
    look.spacing_m = rng.uniform(15, 30);
    look.regular = rng.chance(0.5);
    look.pillar_fraction = 0;
  } else if (kind == CorridorKind::kAlike) {
    look.spacing_m = rng.uniform(2.5, 5);
    look.regular = true;
    look.pillar_fraction = 0.03;
  }
  if (look.regular) look.jitter = 0;
  return look;
}

void add_corridor(FloorWorld& floor, const Point& start, const Point& end, const CorridorLook& look,
                  Rng& rng) {
  CorridorBuilder(floor, start, end, look, rng).build();
}

}  // namespace extperfc::benchmark
