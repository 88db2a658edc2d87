#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "extperfc/mapping/mapper.hpp"

#include "test/support/planar_world.hpp"

namespace extperfc::mapping {

/// A robot on its way through a world, recorded: scans, odometry, and where it really was, seen from its
/// start.
struct MapperDrive {
  std::vector<LaserScan> scans;
  std::vector<Pose2> odometry;
  std::vector<Pose2> truth;

  [[nodiscard]] double error_m(const Pose2& pose, std::size_t i) const {
    const Pose2 off = between(truth[i], pose);
    return std::hypot(off.x, off.y);
  }
};

inline MapperDrive record_drive(const PlanarWorld& world, const std::vector<Pose2>& route, std::uint64_t seed,
                                const PlanarScanner& scanner = {}, PlanarOdometry odometry = {}) {
  Rng rng(seed);
  MapperDrive drive;
  for (std::size_t i = 0; i < route.size(); ++i) {
    drive.truth.push_back(between(route.front(), route[i]));
    const Pose2 step = i == 0 ? Pose2{} : between(route[i - 1], route[i]);
    drive.odometry.push_back(odometry.move(step, rng));
    drive.scans.push_back(scanner.scan(world, route[i], rng, 100.0 + 0.1 * static_cast<double>(i)));
  }
  return drive;
}

/// Around planar_room() once.
inline MapperDrive record_room(std::uint64_t seed) {
  return record_drive(
      planar_room(), planar_drive({{-3, -1.5}, {2, -1.5}, {3, 1}, {0, 1.2}, {-2, 0}, {-3, -1.5}}, 0.15, 0.15),
      seed);
}

inline Mapper make_mapper(const MapperParams& params = {}) {
  return std::move(Mapper::make(params).value());
}

/// Adds scans [first, last) and gives the last update.
inline MapperUpdate add_scans(Mapper& mapper, const MapperDrive& drive, std::size_t first, std::size_t last,
                              bool with_odometry = true) {
  MapperUpdate update;
  for (std::size_t i = first; i < last; ++i)
    update =
        mapper.add(drive.scans[i], with_odometry ? std::optional<Pose2>(drive.odometry[i]) : std::nullopt)
            .value();
  return update;
}

/// Fraction of the cells known to either map that differ between them.
inline double map_difference(const OccupancyGrid& a, const OccupancyGrid& b) {
  std::size_t known = 0;
  std::size_t different = 0;
  const auto compare = [&](const OccupancyGrid& one, const OccupancyGrid& other, bool count_common) {
    for (std::size_t row = 0; row < one.height; ++row)
      for (std::size_t column = 0; column < one.width; ++column) {
        const auto value = one.at(column, row);
        if (value == OccupancyGrid::kUnknown) continue;
        const Pose2 middle = one.middle_of({column, row});
        const auto cell = other.cell_of(middle.x, middle.y);
        const auto elsewhere = cell ? other.at(cell->column, cell->row) : OccupancyGrid::kUnknown;
        if (!count_common && elsewhere != OccupancyGrid::kUnknown) continue;
        ++known;
        if (value != elsewhere) ++different;
      }
  };
  compare(a, b, true);
  compare(b, a, false);
  return known == 0 ? 0.0 : static_cast<double>(different) / static_cast<double>(known);
}

}  // namespace extperfc::mapping
