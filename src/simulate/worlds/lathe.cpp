#include "simulate/worlds/lathe.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "extperfc/base/math.hpp"

namespace extperfc::simulate {

namespace {

constexpr int kRows = 14;  // of a round profile

using Points = std::vector<Eigen::Vector3f>;

Points ring(const Eigen::Vector2d& radius_and_z, int corners) {
  Points points;
  for (int i = 0; i < corners; ++i) {
    const double angle = kTwoPi * (i + 0.5) / corners;
    points.emplace_back(static_cast<float>(radius_and_z.x() * std::cos(angle)),
                        static_cast<float>(radius_and_z.x() * std::sin(angle)),
                        static_cast<float>(radius_and_z.y()));
  }
  return points;
}

void close(std::vector<Triangle>& triangles, const Points& rim, bool top) {
  const Eigen::Vector3f middle(0, 0, rim.front().z());
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const Eigen::Vector3f& here = rim[i];
    const Eigen::Vector3f& next = rim[(i + 1) % rim.size()];
    triangles.push_back(top ? Triangle{middle, here, next} : Triangle{middle, next, here});
  }
}

void join(std::vector<Triangle>& triangles, const Points& lower, const Points& upper) {
  for (std::size_t i = 0; i < lower.size(); ++i) {
    const std::size_t next = (i + 1) % lower.size();
    triangles.push_back({lower[i], lower[next], upper[next]});
    triangles.push_back({lower[i], upper[next], upper[i]});
  }
}

/// Into the unit box about the origin, so that `scale` is the size of the mesh.
void normalise(std::vector<Triangle>& triangles) {
  Eigen::Array3f low = Eigen::Array3f::Constant(1e9F);
  Eigen::Array3f high = -low;
  for (const Triangle& triangle : triangles)
    for (const auto& corner : triangle) {
      low = low.min(corner.array());
      high = high.max(corner.array());
    }
  for (Triangle& triangle : triangles)
    for (auto& corner : triangle) corner = ((corner.array() - (low + high) / 2) / (high - low)).matrix();
}

/// Half a turn of an ellipse from pole to pole; `bulge` moves the widest place down.
std::vector<Eigen::Vector2d> round_profile(double from_rad, double bulge) {
  std::vector<Eigen::Vector2d> profile;
  for (int i = 0; i <= kRows; ++i) {
    const double polar = from_rad + (kPi - from_rad) * i / kRows;
    const double radius = std::sin(polar) * (1 + bulge * std::cos(polar));
    profile.emplace_back(std::max(0.0, radius), -std::cos(polar) / 2);
  }
  return profile;
}

}  // namespace

TriangleMesh lathe(const std::string& name, const std::vector<Eigen::Vector2d>& profile, int corners,
                   const Eigen::Vector3d& size_m) {
  std::vector<Triangle> triangles;
  close(triangles, ring(profile.front(), corners), false);
  for (std::size_t i = 1; i < profile.size(); ++i)
    join(triangles, ring(profile[i - 1], corners), ring(profile[i], corners));
  close(triangles, ring(profile.back(), corners), true);
  normalise(triangles);
  return {name, size_m, std::make_shared<const std::vector<Triangle>>(std::move(triangles))};
}

std::vector<Eigen::Vector2d> ellipse_profile() {
  return round_profile(0, 0);
}

std::vector<Eigen::Vector2d> egg_profile() {
  return round_profile(0, 0.25);
}

std::vector<Eigen::Vector2d> dome_profile() {
  return round_profile(kPi / 2, 0);
}

std::vector<Eigen::Vector2d> frustum_profile(double top) {
  return {{1, -0.5}, {top, 0.5}};
}

std::vector<Eigen::Vector2d> vase_profile(double waist) {
  std::vector<Eigen::Vector2d> profile;
  for (int i = 0; i <= kRows; ++i) {
    const double t = static_cast<double>(i) / kRows;
    profile.emplace_back(1 - (1 - waist) * std::pow(std::sin(kPi * t), 2) * (0.6 + 0.4 * t), t - 0.5);
  }
  return profile;
}

}  // namespace extperfc::simulate
