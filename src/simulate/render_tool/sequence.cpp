#include "simulate/render_tool/sequence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "extperfc/base/math.hpp"
#include "extperfc/simulate/random_world.hpp"
#include "extperfc/simulate/sensor_rig.hpp"

#include "simulate/render_tool/image_maker.hpp"
#include "simulate/render_tool/random_view.hpp"

namespace extperfc::simulate {

namespace fs = std::filesystem;

namespace {

constexpr double kRate_hz = 15;
constexpr double kDistance_m = 0.95;    // of the camera from the objects' middle
constexpr double kElevation_rad = 0.6;  // of the camera above it
constexpr double kSweep_rad = 1.0;      // of the whole arc, before the robot

template <typename... Values>
std::string text_of(const char* format, Values... values) {
  std::array<char, 512> line{};
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

Result<void> write_text(const fs::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  out.close();
  if (out) return {};
  return fail(ErrorCode::kFailed,
              "cannot write " + file.string() + ": is the disk full, or the folder read-only?");
}

std::string camera_info(const CameraModel& camera) {
  return text_of(
             "image_width: %d\nimage_height: %d\ncamera_name: rendered\ncamera_matrix:\n  rows: 3\n  cols: "
             "3\n"
             "  data: [%.6g, 0.0, %.6g, 0.0, %.6g, %.6g, 0.0, 0.0, 1.0]\n",
             camera.width, camera.height, camera.fx, camera.cx, camera.fy, camera.cy) +
         "distortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n"
         "  data: [0.0, 0.0, 0.0, 0.0, 0.0]\nrectification_matrix:\n  rows: 3\n  cols: 3\n"
         "  data: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\n" +
         text_of(
             "projection_matrix:\n  rows: 3\n  cols: 4\n"
             "  data: [%.6g, 0.0, %.6g, 0.0, 0.0, %.6g, %.6g, 0.0, 0.0, 0.0, 1.0, 0.0]\n",
             camera.fx, camera.cx, camera.fy, camera.cy);
}

Result<WorldSpec> world_of(const Options& options) {
  if (!options.world.empty()) return load_world(options.world);
  RandomWorldParams params;
  params.person = 0;  // the path is not looked at before
  return random_world(params, options.seed);
}

Eigen::Vector3d middle_of(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

Pose pose_on_arc(const Eigen::Vector3d& middle, double fraction) {
  const double azimuth = kPi + kSweep_rad * (fraction - 0.5);
  const Eigen::Vector3d eye =
      middle + kDistance_m * Eigen::Vector3d(std::cos(kElevation_rad) * std::cos(azimuth),
                                             std::cos(kElevation_rad) * std::sin(azimuth),
                                             std::sin(kElevation_rad));
  return look_at(eye, middle, 0);
}

/// A recording in the making.
class Recording {
 public:
  Recording(const Options& options, std::unique_ptr<SensorRig> rig, const WorldSpec& world)
      : options_(options), rig_(std::move(rig)), middle_(middle_of(targets_of(world, options.classes))) {
    const double focal = 615.0 / 480.0 * options.height;
    params_.model = {options.width,
                     options.height,
                     focal,
                     focal,
                     (options.width - 1) / 2.0,
                     (options.height - 1) / 2.0,
                     {}};
    params_.supersampling = options.supersampling;
    if (options.plain) params_.depth.subpixel_px = params_.image_noise = 0;
    for (const BodySpec& body : world.bodies) snapshot_.world_T_body.push_back(body.world_T_body);
    for (const PersonSpec& person : world.people)
      snapshot_.world_T_person.push_back({person.path_m[0].x(), person.path_m[0].y(), 0});
  }

  Result<void> add(int number) {
    const Pose pose = pose_on_arc(middle_, number / std::max(1.0, options_.count - 1.0));
    snapshot_.time_s = number / kRate_hz;
    rig_->pose(snapshot_);
    rig_->camera(params_, pose, images_);
    const std::string name = text_of("%06d.png", number);
    const cv::Mat rgb(images_.height, images_.width, CV_8UC3, images_.rgb.data());
    const cv::Mat depth(images_.height, images_.width, CV_16UC1, images_.depth_mm.data());
    cv::Mat bgr;
    cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
    if (!cv::imwrite((options_.out / "rgb" / name).string(), bgr) ||
        !cv::imwrite((options_.out / "depth" / name).string(), depth))
      return fail(ErrorCode::kFailed, "cannot write " + name + " in " + options_.out.string() +
                                          ": is the disk full, or the folder read-only?");
    associations_ += text_of("%.6f rgb/%s %.6f depth/%s\n", snapshot_.time_s, name.c_str(), snapshot_.time_s,
                             name.c_str());
    const Eigen::Vector3d at = pose.translation();
    const Eigen::Quaterniond q(pose.linear());
    poses_ += text_of("%.6f %.6f %.6f %.6f %.6f %.6f %.6f %.6f\n", snapshot_.time_s, at.x(), at.y(), at.z(),
                      q.x(), q.y(), q.z(), q.w());
    return {};
  }

  [[nodiscard]] Result<void> write_lists() const {
    if (auto done = write_text(options_.out / "camera_info.yaml", camera_info(params_.model)); !done)
      return done;
    if (auto done = write_text(options_.out / "associations.txt", associations_); !done) return done;
    return write_text(options_.out / "groundtruth.txt",
                      "# stamp tx ty tz qx qy qz qw: optical frame in the world\n" + poses_);
  }

 private:
  const Options& options_;
  std::unique_ptr<SensorRig> rig_;
  Eigen::Vector3d middle_;
  CameraParams params_;
  Snapshot snapshot_;
  CameraImages images_;
  std::string associations_, poses_;
};

}  // namespace

Result<int> write_sequence(const Options& options, const std::function<bool(int)>& go_on) {
  const auto world = world_of(options);
  if (!world) return tl::unexpected(world.error());
  auto rig = SensorRig::make(RobotModel{}, *world, options.seed);
  if (!rig) return tl::unexpected(rig.error());
  for (const char* name : {"rgb", "depth"}) {
    std::error_code error;
    fs::create_directories(options.out / name, error);
    if (error)
      return fail(ErrorCode::kFailed,
                  "cannot make the folder " + (options.out / name).string() + ": " + error.message());
  }
  Recording recording(options, std::move(*rig), *world);
  int number = 0;
  for (; number < options.count && go_on(number); ++number)
    if (auto added = recording.add(number); !added) return tl::unexpected(added.error());
  if (auto written = recording.write_lists(); !written) return tl::unexpected(written.error());
  return number;
}

}  // namespace extperfc::simulate
