#include "simulate/render_tool/whole_view.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "simulate/render_tool/ray_shape.hpp"

namespace extperfc::simulate {

namespace {

constexpr double kMaxRays = 4000;

/// Pixels that a body can cover.
struct Window {
  double u_min{1e9}, v_min{1e9}, u_max{-1e9}, v_max{-1e9};
};

void widen(Window& window, const CameraModel& camera, const Eigen::Vector3d& centre, double radius) {
  if (centre.z() <= -radius) return;  // behind the camera
  if (centre.z() <= radius * 1.05) {  // around the camera: the image and as much on every side
    const double width = camera.width;
    const double height = camera.height;
    window = {std::min(window.u_min, -width), std::min(window.v_min, -height),
              std::max(window.u_max, 2 * width), std::max(window.v_max, 2 * height)};
    return;
  }
  // Half the size of a sphere's image, from above: seen from the nearest point of its axis.
  const double reach = radius / (centre.z() - radius);
  const double u = camera.cx + camera.fx * centre.x() / centre.z();
  const double v = camera.cy + camera.fy * centre.y() / centre.z();
  const double slant = 1 + centre.head<2>().norm() / centre.z();
  window.u_min = std::min(window.u_min, u - camera.fx * reach * slant);
  window.u_max = std::max(window.u_max, u + camera.fx * reach * slant);
  window.v_min = std::min(window.v_min, v - camera.fy * reach * slant);
  window.v_max = std::max(window.v_max, v + camera.fy * reach * slant);
}

}  // namespace

WholeView whole_view(const BodySpec& body, const CameraModel& camera, const Pose& world_T_optical) {
  Window window;
  std::vector<Pose> shape_T_optical;
  for (const Shape& shape : body.shapes) {
    const Pose optical_T_shape = world_T_optical.inverse() * body.world_T_body * shape.body_T_shape;
    widen(window, camera, optical_T_shape.translation(), bounding_radius_m(shape.geometry));
    shape_T_optical.push_back(optical_T_shape.inverse());
  }
  if (window.u_min > window.u_max) return {};
  const double area = (window.u_max - window.u_min) * (window.v_max - window.v_min);
  const int step = std::max(1, static_cast<int>(std::ceil(std::sqrt(area / kMaxRays))));
  const auto hit = [&](double u, double v) {
    const Eigen::Vector3d direction((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
    for (std::size_t i = 0; i < body.shapes.size(); ++i)
      if (meets({shape_T_optical[i].translation(), shape_T_optical[i].linear() * direction},
                body.shapes[i].geometry))
        return true;
    return false;
  };
  WholeView view;
  for (double v = std::floor(window.v_min); v <= window.v_max; v += step)
    for (double u = std::floor(window.u_min); u <= window.u_max; u += step) {
      if (!hit(u, v)) continue;
      view.pixels += step * step;
      if (u >= 0 && v >= 0 && u < camera.width && v < camera.height) view.pixels_inside += step * step;
    }
  return view;
}

}  // namespace extperfc::simulate
