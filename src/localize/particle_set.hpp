#pragma once

#include <cstddef>
#include <vector>

#include "extperfc/world/pose.hpp"

namespace extperfc::localize {

/// Particles as a structure of arrays. Positions are metres from the map's lower left corner along its own
/// axes and headings are against its x axis [rad], so that single precision keeps micrometres for any
/// origin.
struct ParticleSet {
  std::vector<float> x;
  std::vector<float> y;
  std::vector<float> yaw;
  std::vector<float> weight;

  [[nodiscard]] std::size_t size() const { return x.size(); }
  void resize(std::size_t count) {
    for (auto* values : {&x, &y, &yaw, &weight}) values->resize(count);
  }
  void set(std::size_t i, float x_m, float y_m, float yaw_rad) {
    x[i] = x_m;
    y[i] = y_m;
    yaw[i] = yaw_rad;
  }
  [[nodiscard]] Pose2 pose(std::size_t i) const { return {x[i], y[i], yaw[i]}; }
  void make_weights_equal() { weight.assign(size(), 1.0F / static_cast<float>(size())); }
};

}  // namespace extperfc::localize
