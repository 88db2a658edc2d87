#pragma once

#include <filesystem>

namespace extperfc::ros_test {

/// Writes `frames` pairs of equal names into rgb/ and depth/ [mm] of `folder`: the test's square, 1 m away,
/// before a wall at 2 m. Frame i has its square 10 i pixels further to the right.
void write_recording(const std::filesystem::path& folder, int frames);

/// Writes the same as a TUM RGB-D folder: associations.txt with stamps 100.0, 100.1, ... [s] and depth in
/// 1/5000 m.
void write_tum_recording(const std::filesystem::path& folder, int frames);

/// Writes camera_info.yaml, as camera_calibration does, with this focal length.
void write_camera_info(const std::filesystem::path& file, double focal_px);

}  // namespace extperfc::ros_test
