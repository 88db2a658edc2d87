#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/simulator.hpp"
#include "extperfc/simulate/world_spec.hpp"
#include "extperfc/world/camera_model.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::simulate {

/// Depth errors of an active stereo camera (D435i): see docs/library/depth.md for the model of the noise.
struct DepthNoiseParams {
  double min_depth_m{0.175};   ///< nearer gives no measurement [m]
  double max_depth_m{10.0};    ///< farther gives none [m]
  double focal_px{424.0};      ///< of the infrared pair, at its own resolution
  double baseline_m{0.050};    ///< of the infrared pair
  double subpixel_px{0.08};    ///< standard deviation of the disparity; 0: no noise
  double correlation_px{7.0};  ///< side of the patch whose noise moves together, >= 1; 1: every pixel its own
  double disparity_step_px{1.0 / 32.0};  ///< of the matcher; 0: none. Not used without noise
  double quantum_m{0.001};               ///< depth unit
  double hole_probability{0.002};        ///< of a pixel on a plain surface, [0, 1]
  double edge_holes{0.35};  ///< fraction of pixels without a measurement beside an edge of depth, [0, 1]
};

struct CameraParams {
  CameraModel model{640, 480, 615.0, 615.0, 319.5, 239.5, {}};
  std::uint32_t sensor{0};  ///< number of this camera: seed of its noise
  bool shadows{true};
  bool soft_light{true};  ///< a light with a size and less light in corners; false: sharp shadows, cheaper
  int supersampling{1};   ///< 1 or 2: 2 x 2 rays per pixel, for training images
  double image_noise{0.006};  ///< standard deviation of a colour value, as a fraction of full scale; 0: none
  DepthNoiseParams depth;
};

/// One image. All arrays are width x height, row by row.
struct CameraImages {
  int width{0};
  int height{0};
  std::vector<std::uint8_t> rgb;        ///< 3 per pixel
  std::vector<std::uint16_t> depth_mm;  ///< aligned to colour; 0: no measurement
  std::vector<float> true_depth_m;      ///< without noise; 0: nothing was hit
  std::vector<std::uint16_t> instance;  ///< what is seen, index into SensorRig::instances(); 0: nothing
};

/// Velodyne VLP-16: 16 rings from -15 to +15 degrees, 10 Hz, 300,000 points/s (data sheet 63-9243).
struct LidarParams {
  std::uint32_t sensor{0};   ///< number of this lidar: seed of its noise
  double rotation_hz{10.0};  ///< [5, 20]
  int columns{1875};         ///< firings of all rings per revolution at rotation_hz
  double min_range_m{0.4};
  double max_range_m{100.0};
  double range_noise_m{0.01};  ///< standard deviation (the data sheet promises +-3 cm)
  double quantum_m{0.002};     ///< of the range
  double drop_probability{0.001};
};

struct LidarPoint {
  float x, y, z;       ///< sensor frame [m]
  float intensity;     ///< [0, 255], from the surface's brightness, angle and distance
  std::uint16_t ring;  ///< 0 the lowest
  float time;          ///< since the start of the sweep [s]
};

/// What an instance number of an image stands for.
struct Instance {
  std::string name;   ///< of the body or person; "robot" for the robot's links
  std::string label;  ///< class; empty: background
  int body{-1};       ///< index into WorldSpec::bodies; -1: a person or the robot
};

/// Visible box of an instance in an image: pixels, both ends included.
struct VisibleBox {
  int instance{0};
  int x_min{0}, y_min{0}, x_max{0}, y_max{0};
  int pixels{0};
};

/// Every ray-casting sensor over one scene (Embree, or our own bounding-volume tree where Embree is missing).
/// One thread at a time. Deterministic: noise is drawn from (seed, sensor, time of the snapshot), not from a
/// running sequence; pixels differ by instruction set in the last digit only.
class SensorRig {
 public:
  /// Errors: a mesh that cannot be read.
  [[nodiscard]] static Result<std::unique_ptr<SensorRig>> make(const RobotModel& robot,
                                                               const WorldSpec& world, std::uint64_t seed);
  virtual ~SensorRig() = default;

  /// Moves everything to where it is in the snapshot and updates the tree; what did not move has no cost.
  virtual void pose(const Snapshot& snapshot) = 0;

  /// `images` keeps its memory from call to call; it is empty when the camera model is not valid. Pose: of
  /// the optical frame (x right, y down, z forward).
  virtual void camera(const CameraParams& params, const Pose& world_T_optical, CameraImages& images) = 0;

  /// One revolution. The sensor's pose is interpolated from its start to its end, so points are in the
  /// sensor's frame at their own time, as the real sensor's are. Points are ordered by column, then by ring.
  virtual void lidar(const LidarParams& params, const Pose& world_T_begin, const Pose& world_T_end,
                     std::vector<LidarPoint>& points) = 0;

  /// Distance to the nearest object inside a cone of `half_angle_rad` about the frame's x axis (9 rays: the
  /// axis and eight on the cone), along the ray [m]; infinity: nothing within `max_m`.
  [[nodiscard]] virtual double range(const Pose& world_T_sensor, double half_angle_rad, double max_m) = 0;

  [[nodiscard]] virtual const std::vector<Instance>& instances() const = 0;  ///< [0] is "nothing"
  [[nodiscard]] virtual std::size_t triangles() const = 0;
  [[nodiscard]] virtual const char* engine() const = 0;  ///< "Embree 3.13.5, 16-wide"
};

/// Boxes of labelled instances with at least `min_pixels` visible pixels.
[[nodiscard]] std::vector<VisibleBox> visible_boxes(const CameraImages& images,
                                                    const std::vector<Instance>& instances, int min_pixels);

}  // namespace extperfc::simulate
