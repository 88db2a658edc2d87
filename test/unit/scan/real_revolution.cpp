#include "test/unit/scan/real_revolution.hpp"

#include <cmath>

#include "test/unit/scan/cloud_builder.hpp"

namespace extperfc::scan {

CloudView view_of(const std::vector<VelodynePoint>& points) {
  auto cloud = packed_view(points);
  cloud.x = {offsetof(VelodynePoint, x), NumberType::kFloat32};
  cloud.y = {offsetof(VelodynePoint, y), NumberType::kFloat32};
  cloud.z = {offsetof(VelodynePoint, z), NumberType::kFloat32};
  cloud.intensity = CloudField{offsetof(VelodynePoint, intensity), NumberType::kFloat32};
  cloud.ring = CloudField{offsetof(VelodynePoint, ring), NumberType::kUint16};
  cloud.time = TimeField{{offsetof(VelodynePoint, time), NumberType::kFloat32}, 1.0, 0.0};
  return cloud;
}

CloudView RealRevolution::organised() const {
  CloudView cloud = view_of(points);
  cloud.width = 16;
  cloud.height = firings;
  cloud.row_step = 16 * sizeof(VelodynePoint);
  return cloud;
}

std::vector<VelodynePoint> returns_of(const RealRevolution& revolution) {
  std::vector<VelodynePoint> points;
  for (const auto& point : revolution.points)
    if (!std::isnan(point.x)) points.push_back(point);
  return points;
}

}  // namespace extperfc::scan
