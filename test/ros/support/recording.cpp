#include "test/ros/support/recording.hpp"

#include <fstream>
#include <string>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "test/ros/support/images.hpp"

namespace extperfc::ros_test {

namespace {

void write_frame(const std::filesystem::path& folder, int index, double units_per_m) {
  const std::string name = std::to_string(index) + ".png";
  const cv::Rect where = kSquare + cv::Point(10 * index, 0);
  cv::Mat bgr;
  cv::cvtColor(draw_square(kRed, where), bgr, cv::COLOR_RGB2BGR);
  cv::imwrite((folder / "rgb" / name).string(), bgr);
  cv::Mat1w depth(kSize, static_cast<std::uint16_t>(2.0 * units_per_m));
  depth(where).setTo(units_per_m);
  cv::imwrite((folder / "depth" / name).string(), depth);
}

void write_frames(const std::filesystem::path& folder, int frames, double units_per_m) {
  std::filesystem::create_directories(folder / "rgb");
  std::filesystem::create_directories(folder / "depth");
  for (int i = 0; i < frames; ++i) write_frame(folder, i, units_per_m);
}

}  // namespace

void write_recording(const std::filesystem::path& folder, int frames) {
  write_frames(folder, frames, 1000.0);
}

void write_tum_recording(const std::filesystem::path& folder, int frames) {
  write_frames(folder, frames, 5000.0);
  std::ofstream list(folder / "associations.txt");
  list << "# stamp file stamp file\n";
  for (int i = 0; i < frames; ++i) {
    const std::string stamp = std::to_string(100.0 + 0.1 * i);
    list << stamp << " rgb/" << i << ".png " << stamp << " depth/" << i << ".png\n";
  }
}

void write_camera_info(const std::filesystem::path& file, double focal_px) {
  std::ofstream(file) << "image_width: " << kSize.width << "\nimage_height: " << kSize.height
                      << "\ncamera_name: test\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [" << focal_px
                      << ", 0, 160, 0, " << focal_px << ", 120, 0, 0, 1]\n"
                      << "distortion_model: plumb_bob\ndistortion_coefficients:\n"
                      << "  rows: 1\n  cols: 5\n  data: [0, 0, 0, 0, 0]\n";
}

}  // namespace extperfc::ros_test
