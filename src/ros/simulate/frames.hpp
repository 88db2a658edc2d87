#pragma once

/// Frames of the simulated robot (REP 105); those of the robot itself are links of its URDF.
namespace extperfc::frames {

inline constexpr const char* kMap = "map";  ///< of the world's file
inline constexpr const char* kOdom = "odom";
inline constexpr const char* kFootprint = "base_footprint";
inline constexpr const char* kImu = "imu_link";
inline constexpr const char* kCamera = "camera_color_optical_frame";
inline constexpr const char* kLidar = "velodyne";
inline constexpr const char* kSonar = "sonar_ring";

}  // namespace extperfc::frames
