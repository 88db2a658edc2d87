#pragma once

/// Frames of the simulated robot (REP 105); those of the robot itself are links of its URDF.
namespace extperfc::ros_simulate {

inline constexpr const char* kMapFrame = "map";  ///< of the world's file
inline constexpr const char* kOdomFrame = "odom";
inline constexpr const char* kFootprintFrame = "base_footprint";
inline constexpr const char* kImuFrame = "imu_link";
inline constexpr const char* kCameraFrame = "camera_color_optical_frame";
inline constexpr const char* kLidarFrame = "velodyne";
inline constexpr const char* kSonarFrame = "sonar_ring";

}  // namespace extperfc::ros_simulate
