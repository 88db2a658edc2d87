#pragma once

#include <string>
#include <vector>

#include "extperfc/simulate/sensor_rig.hpp"
#include "extperfc/simulate/world_spec.hpp"

namespace extperfc::ros_simulate {

/// Class ids of the ground truth: those of the detector's model first, further labels of the world after
/// them in order of appearance.
class TruthClasses {
 public:
  TruthClasses(std::vector<std::string> known, const simulate::WorldSpec& world);

  /// -1 for a label that no body has, the empty one included.
  [[nodiscard]] int id(const std::string& label) const;
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

 private:
  std::vector<std::string> names_;
};

}  // namespace extperfc::ros_simulate
