#include "arm/grasping/contact.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "arm/grasping/chord.hpp"

namespace extperfc::arm {
namespace {

constexpr int kGrid = 17;          // odd: the middle is one of them
constexpr double kPatch = 0.0005;  // [m], what a soft pad gives way

/// In the tip's plane y = 0.
struct Rectangle {
  double x_half, z_low, z_high;
  [[nodiscard]] double x(int i) const { return x_half * (2.0 * i / (kGrid - 1) - 1); }
  [[nodiscard]] double z(int i) const { return z_low + (z_high - z_low) * i / (kGrid - 1); }
  [[nodiscard]] bool holds(double x, double z) const {
    return std::abs(x) <= x_half && z >= z_low && z <= z_high;
  }
};

/// How far a part reaches on either side of the middle plane, within a rectangle of it.
class Profile {
 public:
  Profile(const ConvexPart& part, const Pose& part_T_tip, const Rectangle& rectangle)
      : part_(part), part_T_tip_(part_T_tip), rectangle_(rectangle) {
    const Eigen::Vector3d along = part_T_tip.linear().col(1);
    for (int i = 0; i < kGrid; ++i)
      for (int k = 0; k < kGrid; ++k) {
        half_[i][k] = -1;
        const auto inside =
            chord(part, part_T_tip * Eigen::Vector3d(rectangle.x(i), 0, rectangle.z(k)), along);
        if (!inside || !(inside->to > 0 || inside->from < 0)) continue;
        half_[i][k] = std::max(inside->to, -inside->from);
        if (half_[i][k] > largest_ + 1e-12) {
          largest_ = half_[i][k];
          at_x_ = i;
          at_z_ = k;
        }
      }
    find_extreme();
  }

  [[nodiscard]] bool empty() const { return largest_ <= 0; }
  [[nodiscard]] double largest() const { return largest_; }

  /// A pad's inside meets the surface square, or at a corner of it; a pad's edge meets it as it leans.
  [[nodiscard]] double lean_rad() const {
    if (extreme_inside_ || (at_x_ % (kGrid - 1) != 0 && at_z_ % (kGrid - 1) != 0)) return 0;
    const Eigen::Vector3d point =
        part_T_tip_ * Eigen::Vector3d(rectangle_.x(at_x_), largest_, rectangle_.z(at_z_));
    const double along = outward_normal(part_, point).dot(part_T_tip_.linear().col(1));
    return std::acos(std::clamp(along, 0.0, 1.0));
  }

  [[nodiscard]] PadContact contact() const {
    PadContact contact{largest_, lean_rad()};
    int hits = 0, low_x = kGrid, high_x = -1, low_z = kGrid, high_z = -1;
    for (int i = 0; i < kGrid; ++i)
      for (int k = 0; k < kGrid; ++k) {
        if (half_[i][k] < 0) continue;
        low_x = std::min(low_x, i);
        high_x = std::max(high_x, i);
        low_z = std::min(low_z, k);
        high_z = std::max(high_z, k);
        if (half_[i][k] >= largest_ - kPatch) ++hits;
      }
    if (high_x < 0) return contact;
    // Half a cell on either side: a line stands for the cell about it.
    contact.overlap_x_m = 2 * rectangle_.x_half * (high_x - low_x + 1) / kGrid;
    contact.overlap_z_m = (rectangle_.z_high - rectangle_.z_low) * (high_z - low_z + 1) / kGrid;
    contact.fraction = static_cast<double>(hits) / (kGrid * kGrid);
    return contact;
  }

 private:
  /// The farthest point of the whole part, exactly, if it is within the rectangle.
  void find_extreme() {
    const Eigen::Vector3d along = part_T_tip_.linear().col(1);
    const Eigen::Vector3d point = part_T_tip_.inverse() * support(part_, along);
    if (!rectangle_.holds(point.x(), point.z())) return;
    extreme_inside_ = true;
    largest_ = std::max(largest_, point.y());
  }

  const ConvexPart& part_;
  const Pose& part_T_tip_;
  Rectangle rectangle_;
  std::array<std::array<double, kGrid>, kGrid> half_{};  ///< negative: nothing there
  double largest_{0};
  int at_x_{0}, at_z_{0};
  bool extreme_inside_{false};
};

}  // namespace

double half_extent_m(const ConvexPart& part, const Pose& part_T_tip) {
  const Eigen::Vector3d along = part_T_tip.linear().col(1);
  return along.dot(support(part, along) - part_T_tip.translation());
}

std::optional<PadContact> contact_of(const ParallelHand& hand, const ConvexPart& part,
                                     const Pose& part_T_tip) {
  const FingerPart& pad = hand.parts.front();
  const Profile profile(part, part_T_tip, {pad.x_half_m, pad.z_low_m, pad.z_high_m});
  if (profile.empty()) return std::nullopt;
  PadContact contact = profile.contact();
  // Another piece of the finger may meet the part before the pad does.
  for (std::size_t i = 1; i < hand.parts.size(); ++i) {
    const FingerPart& piece = hand.parts[i];
    if (half_extent_m(part, part_T_tip) - piece.inset_m <= contact.half_width_m) continue;
    const Profile other(part, part_T_tip, {piece.x_half_m, piece.z_low_m, piece.z_high_m});
    if (other.empty() || other.largest() - piece.inset_m <= contact.half_width_m) continue;
    contact.half_width_m = other.largest() - piece.inset_m;
    contact.lean_rad = other.lean_rad();
  }
  return contact;
}

double passage_half_width_m(const ParallelHand& hand, const ConvexPart& part, const Pose& part_T_tip) {
  const double whole = half_extent_m(part, part_T_tip);
  double largest = 0;
  for (const FingerPart& piece : hand.parts) {
    if (whole - piece.inset_m <= largest) continue;
    const double back = std::min(hand.palm_high.z(), piece.z_low_m);
    const Profile profile(part, part_T_tip, {piece.x_half_m, back, piece.z_high_m});
    if (!profile.empty()) largest = std::max(largest, profile.largest() - piece.inset_m);
  }
  return largest;
}

double lowest_z_m(const ParallelHand& hand, const Pose& root_T_tip, double opening_m) {
  const Eigen::Vector3d up = root_T_tip.linear().row(2);
  const auto lowest_of = [&](const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    return up.dot((up.array() < 0).select(high, low));
  };
  double lowest = lowest_of(hand.palm_low, hand.palm_high);
  for (const FingerPart& piece : hand.parts) {
    const double outer = opening_m / 2 + piece.inset_m + piece.thickness_m;
    lowest = std::min(
        lowest, lowest_of({-piece.x_half_m, -outer, piece.z_low_m}, {piece.x_half_m, outer, piece.z_high_m}));
  }
  return root_T_tip.translation().z() + lowest;
}

Eigen::Vector3d pad_middle(const ParallelHand& hand) {
  const FingerPart& pad = hand.parts.front();
  return {0, 0, (pad.z_low_m + pad.z_high_m) / 2};
}

}  // namespace extperfc::arm
