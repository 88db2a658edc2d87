#include "navigate/local/shrunk_footprints.hpp"

namespace extperfc::navigate {

void ShrunkFootprints::set(const Footprint& footprint) {
  if (!footprints_.empty() && footprints_.front().corners_m() == footprint.corners_m()) return;
  footprints_.clear();
  footprints_.reserve(kMargins_m.size());
  for (const double margin_m : kMargins_m) footprints_.push_back(footprint.padded(-margin_m));
}

std::size_t ShrunkFootprints::depth(const CostGrid& costs, const Pose2& pose) const {
  for (std::size_t i = 0; i < footprints_.size(); ++i)
    if (contact(costs, footprints_[i], pose) == Contact::kFree) return i;
  return footprints_.size();
}

}  // namespace extperfc::navigate
