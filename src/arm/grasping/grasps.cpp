#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "extperfc/arm/grasp.hpp"
#include "extperfc/base/math.hpp"

#include "arm/collision/convex_part.hpp"
#include "arm/grasping/closings.hpp"
#include "arm/grasping/contact.hpp"

namespace extperfc::arm {
namespace {

constexpr double kNoSupportGap = 1.0;      // [m]
constexpr double kSupportFalloff = 0.005;  // [m]: at this gap the score is halved

enum Refusal { kTooWide, kTooThin, kUncertain, kSlips, kNoRoom, kMissed, kRefusals };

std::string millimetres(double metres) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f mm", 1000 * metres);
  return text.data();
}

/// Looks at the poses of a hand one by one.
class Generator {
 public:
  Generator(const ParallelHand& hand, const GraspObject& object, const GraspParams& params,
            const ConvexPart& part)
      : hand_(hand), object_(object), params_(params), part_(part) {
    root_T_part_ = object.root_T_object * part.body_T_part;
  }

  void run() {
    for (const auto& closing : closings_of(part_, root_T_part_, params_))
      for (const auto& approach : approaches_of(closing.along, params_))
        for (const auto& centre : closing.centres) look_at(closing.along, approach, centre);
  }

  [[nodiscard]] std::vector<GraspCandidate>& found() { return found_; }

  [[nodiscard]] Error reason() const {
    const auto degrees = [](double rad) {
      return std::to_string(std::lround(rad * 57.29577951)) + " degrees";
    };
    std::string text = "no grasp:";
    if (refused_[kTooWide] > 0)
      text += " too wide, " + millimetres(min_width_m_) + " at the narrowest where the fingers pass, with " +
              millimetres(params_.side_clearance_m) + " of clearance on either side; the gripper opens to " +
              millimetres(hand_.opening_max_m) + ";";
    if (refused_[kTooThin] > 0)
      text += " thinner than " + millimetres(hand_.opening_min_m) + ", to which the gripper closes;";
    if (refused_[kUncertain] > 0)
      text += " the position is too uncertain, " + std::to_string(params_.sigmas) + " sigmas are up to " +
              millimetres(uncertainty_m_) + ";";
    if (refused_[kSlips] > 0)
      text += " the surface leans by at least " + degrees(lean_rad_) + " against the pads, friction holds " +
              degrees(std::atan(max_slope())) + ";";
    if (refused_[kNoRoom] > 0) text += " no clearance for the gripper above the support;";
    if (refused_[kMissed] > 0) text += " the pads do not reach it;";
    text.back() = '.';
    return {ErrorCode::kFailed, text};
  }

 private:
  [[nodiscard]] double max_slope() const { return params_.friction * params_.friction_ratio; }

  [[nodiscard]] double sigma_m(const Eigen::Vector3d& direction) const {
    return std::sqrt(std::max(0.0, direction.dot(object_.covariance * direction)));
  }

  /// Away from the palm, then from the support. The middle plane stays.
  [[nodiscard]] Pose cleared(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& centre) const {
    Pose root_T_tip = Pose::Identity();
    root_T_tip.linear() = rotation;
    root_T_tip.translation() = centre - rotation * pad_middle(hand_);
    const Eigen::Vector3d approach = rotation.col(2);
    const Eigen::Vector3d nearest =
        root_T_part_ * support(part_, root_T_part_.linear().transpose() * -approach);
    const double gap = approach.dot(nearest - root_T_tip.translation()) - hand_.palm_high.z();
    const double wanted = params_.palm_clearance_m + params_.sigmas * sigma_m(approach);
    if (gap < wanted) root_T_tip.translation() -= (wanted - gap) * approach;
    if (!object_.support_z_m) return root_T_tip;
    const double low = lowest_z_m(hand_, root_T_tip, hand_.opening_max_m) - *object_.support_z_m;
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ() - rotation(2, 1) * rotation.col(1);
    if (low < params_.support_clearance_m && up.z() > 0.1)
      root_T_tip.translation() += (params_.support_clearance_m + 1e-9 - low) / up.z() * up;
    return root_T_tip;
  }

  void refuse(Refusal refusal) { ++refused_[refusal]; }

  void look_at(const Eigen::Vector3d& along, const Eigen::Vector3d& approach, const Eigen::Vector3d& centre) {
    Eigen::Matrix3d rotation;
    rotation << along.cross(approach), along, approach;
    const Pose root_T_tip = cleared(rotation, centre);
    const double gap = !object_.support_z_m
                           ? kNoSupportGap
                           : lowest_z_m(hand_, root_T_tip, hand_.opening_max_m) - *object_.support_z_m;
    if (gap < params_.support_clearance_m) return refuse(kNoRoom);
    const Pose part_T_tip = root_T_part_.inverse() * root_T_tip;
    const auto contact = contact_of(hand_, part_, part_T_tip);
    if (!contact ||
        std::min(contact->overlap_x_m, 2 * hand_.parts[0].x_half_m) <
            std::min(params_.min_overlap_m, hand_.parts[0].x_half_m) ||
        contact->overlap_z_m < params_.min_overlap_m)
      return refuse(kMissed);
    // Where the widest place is between the pads there is nothing wider on the path.
    const bool widest = contact->half_width_m >= half_extent_m(part_, part_T_tip) - 1e-9;
    const double passage = widest ? contact->half_width_m : passage_half_width_m(hand_, part_, part_T_tip);
    judge(root_T_tip, *contact, 2 * passage, gap);
  }

  void judge(const Pose& root_T_tip, const PadContact& contact, double passage_m, double gap_m) {
    const double needed = std::max(passage_m, 2 * contact.half_width_m) + 2 * params_.side_clearance_m;
    if (needed > hand_.opening_max_m) {
      min_width_m_ = std::min(min_width_m_, needed - 2 * params_.side_clearance_m);
      return refuse(kTooWide);
    }
    if (2 * contact.half_width_m < hand_.opening_min_m) return refuse(kTooThin);
    const Eigen::Matrix3d rotation = root_T_tip.linear();
    const double sideways = sigma_m(rotation.col(1)), along_pad = sigma_m(rotation.col(0));
    const double opening = needed + 2 * params_.sigmas * sideways;
    if (opening > hand_.opening_max_m ||
        params_.sigmas * along_pad > hand_.parts[0].x_half_m + contact.overlap_x_m / 2) {
      uncertainty_m_ = std::max({uncertainty_m_, params_.sigmas * sideways, params_.sigmas * along_pad});
      return refuse(kUncertain);
    }
    if (std::tan(contact.lean_rad) > max_slope()) {
      lean_rad_ = std::min(lean_rad_, contact.lean_rad);
      return refuse(kSlips);
    }
    add(root_T_tip, contact, opening, gap_m);
  }

  void add(const Pose& root_T_tip, const PadContact& contact, double opening_m, double gap_m) {
    GraspCandidate candidate;
    candidate.root_T_tip = root_T_tip;
    candidate.approach = root_T_tip.linear().col(2);
    candidate.approach_m = params_.approach_m;
    candidate.lift_m = params_.lift_m;
    candidate.opening_m = opening_m;
    candidate.spare_m = hand_.opening_max_m - opening_m;
    candidate.closed_m = 2 * contact.half_width_m;
    candidate.lean_rad = contact.lean_rad;
    candidate.support_gap_m = gap_m;
    candidate.score = score(candidate, contact);
    for (const double yaw : {0.0, kPi}) {
      candidate.root_T_tip.linear() =
          root_T_tip.linear() * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      candidate.root_T_pregrasp = candidate.root_T_tip;
      candidate.root_T_pregrasp.translation() -= candidate.approach_m * candidate.approach;
      candidate.tip_T_object = candidate.root_T_tip.inverse() * object_.root_T_object;
      found_.push_back(candidate);
    }
  }

  [[nodiscard]] double score(const GraspCandidate& candidate, const PadContact& contact) const {
    const double sigma = sigma_m(candidate.root_T_tip.linear().col(1));
    const double room = (hand_.opening_max_m - candidate.closed_m) / 2;
    const double between = sigma > 0 ? std::erf(room / (std::sqrt(2.0) * sigma)) : 1;
    const double held = 1 - std::tan(candidate.lean_rad) / params_.friction;
    const double overlap = 0.6 + 0.4 * std::sqrt(contact.fraction);
    const Eigen::Vector3d pads = candidate.root_T_tip * pad_middle(hand_);
    const double lever = (pads - mass_centre()).norm() / (hand_.parts[0].z_high_m - hand_.parts[0].z_low_m);
    const double top = 1 - params_.prefer_top * (1 + candidate.approach.z()) / 2;
    const double support = candidate.support_gap_m / (candidate.support_gap_m + kSupportFalloff);
    return std::clamp(between * held * overlap * top * support / (1 + lever * lever), 1e-9, 1.0);
  }

  [[nodiscard]] Eigen::Vector3d mass_centre() const {
    if (part_.kind != PartKind::kCone) return root_T_part_.translation();
    return root_T_part_ * Eigen::Vector3d(0, 0, -part_.half.z() / 2);
  }

  const ParallelHand& hand_;
  const GraspObject& object_;
  const GraspParams& params_;
  const ConvexPart& part_;
  Pose root_T_part_{Pose::Identity()};
  std::vector<GraspCandidate> found_;
  std::array<int, kRefusals> refused_{};
  double min_width_m_{1e9}, uncertainty_m_{0}, lean_rad_{1e9};
};

Result<void> check_object(const GraspObject& object) {
  if (std::holds_alternative<TriangleMesh>(object.geometry))
    return fail(ErrorCode::kUnsupported,
                "no grasps of a mesh: give a box, cylinder, sphere or cone about it");
  if (!object.root_T_object.matrix().allFinite() || !object.root_T_object.linear().isUnitary(1e-6))
    return fail(ErrorCode::kInvalidArgument, "the object's pose is no finite rigid transform");
  if (!object.covariance.allFinite() || object.covariance.diagonal().minCoeff() < 0 ||
      !object.covariance.isApprox(object.covariance.transpose(), 1e-6))
    return fail(ErrorCode::kInvalidArgument,
                "the object's covariance is not finite, not symmetric or negative");
  if (object.support_z_m && !std::isfinite(*object.support_z_m))
    return fail(ErrorCode::kInvalidArgument, "the height of the support is not finite");
  return {};
}

}  // namespace

Result<std::vector<GraspCandidate>> generate_grasps(const ParallelHand& hand, const GraspObject& object,
                                                    const GraspParams& params) {
  if (auto ok = params.validate(); !ok) return tl::unexpected<Error>(ok.error());
  if (auto ok = hand.validate(); !ok) return tl::unexpected<Error>(ok.error());
  if (auto ok = check_object(object); !ok) return tl::unexpected<Error>(ok.error());
  Shape shape;
  shape.geometry = object.geometry;
  const auto part = make_convex_part(shape);
  if (!part) return tl::unexpected<Error>(part.error());
  Generator generator(hand, object, params, **part);
  generator.run();
  auto& found = generator.found();
  if (found.empty()) return tl::unexpected<Error>(generator.reason());
  std::stable_sort(found.begin(), found.end(),
                   [](const GraspCandidate& a, const GraspCandidate& b) { return a.score > b.score; });
  if (found.size() > static_cast<std::size_t>(params.max_candidates)) found.resize(params.max_candidates);
  return std::move(found);
}

}  // namespace extperfc::arm
