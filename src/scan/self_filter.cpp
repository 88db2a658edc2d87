#include "extperfc/scan/self_filter.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/world/frame_about.hpp"

namespace extperfc::scan {

namespace {

constexpr std::size_t kMaxVolumes = 256;
constexpr double kLargest = 5.0;  // [m]

bool is_size(double value, bool zero_is_one = false) {
  return std::isfinite(value) && value <= kLargest && (zero_is_one ? value >= 0 : value > 0);
}

tl::unexpected<Error> wrong(std::size_t index, const SelfVolume& volume, const std::string& what) {
  return fail(ErrorCode::kInvalidArgument,
              "self filter's volume " + std::to_string(index) + " (frame '" + volume.frame + "'): " + what);
}

Result<void> validate(std::size_t index, const SelfVolume& volume) {
  if (volume.frame.empty()) return wrong(index, volume, "it needs a frame");
  if (volume.capsule.has_value() == volume.box.has_value())
    return wrong(index, volume, "it must be either a capsule or a box");
  if (volume.capsule &&
      !(is_size(volume.capsule->radius_m) && volume.capsule->from.allFinite() &&
        volume.capsule->to.allFinite() && is_size((volume.capsule->to - volume.capsule->from).norm(), true)))
    return wrong(index, volume, "radius and length of a capsule must lie in (0, 5] m");
  if (volume.box && !(is_size(volume.box->size.minCoeff()) && is_size(volume.box->size.maxCoeff()) &&
                      volume.box->frame_T_box.matrix().allFinite()))
    return wrong(index, volume, "the sizes of a box must lie in (0, 5] m");
  return {};
}

/// The frame of a capsule: in its middle, z along its line.
Pose along(const Capsule& capsule) {
  Pose pose = Pose::Identity();
  pose.translation() = 0.5 * (capsule.from + capsule.to);
  const Eigen::Vector3d line = capsule.to - capsule.from;
  if (line.norm() > 0) pose.linear() = frame_about(line);
  return pose;
}

}  // namespace

Result<SelfFilter> SelfFilter::make(const std::vector<SelfVolume>& volumes, double padding_m) {
  if (!is_size(padding_m, true))
    return fail(ErrorCode::kInvalidArgument, "the self filter's padding must lie in [0, 5] m");
  if (volumes.size() > kMaxVolumes)
    return fail(ErrorCode::kInvalidArgument, "the self filter takes " + std::to_string(kMaxVolumes) +
                                                 " volumes at most, not " + std::to_string(volumes.size()));
  SelfFilter filter;
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    const SelfVolume& volume = volumes[i];
    if (auto valid = validate(i, volume); !valid) return tl::unexpected(valid.error());
    const auto known = std::find(filter.frames_.begin(), filter.frames_.end(), volume.frame);
    Part part;
    part.frame = static_cast<std::size_t>(known - filter.frames_.begin());
    if (known == filter.frames_.end()) filter.frames_.push_back(volume.frame);
    if (volume.capsule) {
      part.frame_T_part = along(*volume.capsule);
      part.half.z() = static_cast<float>(0.5 * (volume.capsule->to - volume.capsule->from).norm());
      part.radius = static_cast<float>(volume.capsule->radius_m + padding_m);
    } else {
      part.frame_T_part = volume.box->frame_T_box;
      part.half = 0.5F * volume.box->size.cast<float>();
      part.radius = static_cast<float>(padding_m);
    }
    filter.parts_.push_back(part);
  }
  return filter;
}

void SelfFilter::place(const std::vector<std::optional<Pose>>& sensor_T_frame) {
  placed_.clear();
  reach_squared_ = 0;
  for (const Part& part : parts_) {
    if (part.frame >= sensor_T_frame.size() || !sensor_T_frame[part.frame]) continue;
    const Pose sensor_T_part = *sensor_T_frame[part.frame] * part.frame_T_part;
    Placed placed;
    placed.middle = sensor_T_part.translation().cast<float>();
    placed.part_R_sensor = sensor_T_part.linear().transpose().cast<float>();
    placed.half = part.half;
    placed.radius_squared = part.radius * part.radius;
    const float reach = part.half.norm() + part.radius;
    placed.reach_squared = reach * reach;
    const float farthest = placed.middle.norm() + reach;
    reach_squared_ = std::max(reach_squared_, farthest * farthest);
    placed_.push_back(placed);
  }
}

bool SelfFilter::contains(const Eigen::Vector3f& point) const {
  if (!(point.squaredNorm() <= reach_squared_)) return false;  // NaN goes here too
  for (const Placed& placed : placed_) {
    const Eigen::Vector3f off = point - placed.middle;
    if (off.squaredNorm() > placed.reach_squared) continue;
    // A capsule is a box without width, a padded box has round edges: both are "near to a box".
    const Eigen::Vector3f beside =
        ((placed.part_R_sensor * off).cwiseAbs() - placed.half).cwiseMax(Eigen::Vector3f::Zero());
    if (beside.squaredNorm() <= placed.radius_squared) return true;
  }
  return false;
}

}  // namespace extperfc::scan
