#include "ros/simulate/truth_classes.hpp"

#include <algorithm>
#include <utility>

namespace extperfc::ros_simulate {

TruthClasses::TruthClasses(std::vector<std::string> known, const simulate::WorldSpec& world)
    : names_(std::move(known)) {
  for (const auto& body : world.bodies)
    if (!body.label.empty() && id(body.label) < 0) names_.push_back(body.label);
  if (!world.people.empty() && id("person") < 0) names_.emplace_back("person");
}

int TruthClasses::id(const std::string& label) const {
  const auto found = std::find(names_.begin(), names_.end(), label);
  return found == names_.end() ? -1 : static_cast<int>(found - names_.begin());
}

}  // namespace extperfc::ros_simulate
