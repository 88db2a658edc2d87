#pragma once

#include <cstddef>

#include "scan/cloud_points.hpp"

namespace extperfc::scan {

/// Fills points.time_s from the azimuth of a sensor that rotates clockwise, once in options.revolution_s;
/// rows of `row_points` points restart, in a row points are in the order of their firing. Left empty when
/// they are not: then the azimuths add up to much more than one revolution.
void times_from_azimuth(CloudPoints& points, std::size_t row_points, const ReadOptions& options);

}  // namespace extperfc::scan
