#include "scan/cloud_points.hpp"

#include <cmath>
#include <optional>

#include "scan/azimuth_times.hpp"
#include "scan/field_reader.hpp"

namespace extperfc::scan {

namespace {

/// Fields that only some clouds have, or only some users want.
struct Extras {
  std::optional<AnyField> intensity, ring, time;
  double time_unit_s{1};
  double time_origin_s{0};

  void read(const std::uint8_t* point, std::size_t i, CloudPoints& points) const {
    if (intensity) points.intensity[i] = static_cast<float>((*intensity)(point));
    if (ring) points.level[i] = static_cast<float>((*ring)(point));
    if (time) points.time_s[i] = static_cast<float>((*time)(point)*time_unit_s - time_origin_s);
  }
};

Extras extras_of(const CloudView& cloud, const ReadOptions& options) {
  Extras extras;
  if (options.intensity && cloud.intensity) extras.intensity.emplace(cloud, *cloud.intensity);
  if (cloud.ring) extras.ring.emplace(cloud, *cloud.ring);
  if (options.time && cloud.time) {
    extras.time.emplace(cloud, cloud.time->field);
    extras.time_unit_s = cloud.time->unit_s;
    extras.time_origin_s = cloud.time->origin_s;
  }
  return extras;
}

/// Returns the number of points that were wanted.
template <typename Field, typename Wanted>
std::size_t read_into(const CloudView& cloud, const Extras& extras, Wanted wanted, CloudPoints& points) {
  const Field x(cloud, cloud.x);
  const Field y(cloud, cloud.y);
  const Field z(cloud, cloud.z);
  std::size_t i = 0;
  for_each_point(cloud, [&](const std::uint8_t* point) {
    if (!wanted(point)) return;
    points.sensor_x[i] = static_cast<float>(x(point));
    points.sensor_y[i] = static_cast<float>(y(point));
    points.sensor_z[i] = static_cast<float>(z(point));
    extras.read(point, i, points);
    ++i;
  });
  return i;
}

template <typename Field>
std::size_t read_with(const CloudView& cloud, const Extras& extras, const RingSet* rings,
                      CloudPoints& points) {
  if (!rings)
    return read_into<Field>(
        cloud, extras, [](const std::uint8_t*) { return true; }, points);
  const AnyField ring(cloud, *cloud.ring);
  const auto selected = [&](const std::uint8_t* point) {
    const double number = ring(point);
    return number >= 0 && number < static_cast<double>(rings->size()) &&
           rings->test(static_cast<std::size_t>(number));
  };
  return read_into<Field>(cloud, extras, selected, points);
}

bool is_plain_float(const CloudView& cloud) {
  return cloud.big_endian == kHostIsBigEndian && cloud.x.type == NumberType::kFloat32 &&
         cloud.y.type == NumberType::kFloat32 && cloud.z.type == NumberType::kFloat32;
}

/// Without a ring field, rings are separated by their elevation, in steps of half a degree.
void levels_from_elevation(CloudPoints& points) {
  constexpr float kLevelsPerRad = 2 * 57.29578F;
  for (std::size_t i = 0; i < points.level.size(); ++i) {
    const float x = points.sensor_x[i];
    const float y = points.sensor_y[i];
    points.level[i] = kLevelsPerRad * std::atan2(points.sensor_z[i], std::sqrt(x * x + y * y));
  }
}

void resize(CloudPoints& points, std::size_t size, const ReadOptions& options, const CloudView& cloud) {
  for (auto* values :
       {&points.sensor_x, &points.sensor_y, &points.sensor_z, &points.x, &points.y, &points.z, &points.level})
    values->resize(size);
  points.intensity.resize(options.intensity && cloud.intensity ? size : 0);
  points.time_s.resize(options.time && cloud.time ? size : 0);
}

}  // namespace

void read_points(const CloudView& cloud, const ReadOptions& options, CloudPoints& points) {
  resize(points, cloud.size(), options, cloud);
  const Extras extras = extras_of(cloud, options);
  const std::size_t kept = is_plain_float(cloud) ? read_with<FloatField>(cloud, extras, options.rings, points)
                                                 : read_with<AnyField>(cloud, extras, options.rings, points);
  resize(points, kept, options, cloud);
  if (!cloud.ring) levels_from_elevation(points);
  if (options.time && !cloud.time && options.azimuth_times != AzimuthTimes::kNone) {
    // Rows of rings, each with all azimuths, restart; rows of firings continue.
    const bool rows_are_rings = cloud.height > 1 && cloud.height < cloud.width && !options.rings;
    times_from_azimuth(points, rows_are_rings ? cloud.width : kept, options);
  }
}

}  // namespace extperfc::scan
