#pragma once

#include <optional>
#include <vector>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/velocity.hpp"
#include "extperfc/world/pose.hpp"

#include "navigate/global/plan_clock.hpp"
#include "navigate/global/pose_search.hpp"
#include "navigate/global/traversal.hpp"

namespace extperfc::navigate {

/// Checks a path with the true footprint, and replaces what touches by a local search over x, y and yaw in a
/// corridor around it. Everything must live as long as the refiner.
class FootprintRefiner {
 public:
  FootprintRefiner(const CostGrid& costs, const Footprint& footprint, const Traversal& traversal,
                   BaseKind base, const PlanClock& clock);

  enum class Status { kFree, kBlocked, kInterrupted };
  struct Refined {
    Status status{Status::kFree};
    std::vector<Pose2> poses;      ///< kFree: at most 0.1 m and 0.2 rad apart, no contact on and between them
    std::optional<Pose2> where{};  ///< kBlocked: how far the footprint comes
  };

  /// The first and the last pose stay. A differential base passes narrow places straight, and in curves what
  /// is wide. Precondition: both are free.
  [[nodiscard]] Refined refine(std::vector<Pose2> poses) const;

  /// No contact; unknown space counts as none where the traversal admits it.
  [[nodiscard]] bool is_free(const Pose2& pose) const;
  [[nodiscard]] bool is_free_along(const Pose2& from, const Pose2& to) const;

 private:
  [[nodiscard]] bool is_free(const Footprint& footprint, const Pose2& pose) const;
  [[nodiscard]] bool is_free_along(const Footprint& footprint, const Pose2& from, const Pose2& to) const;
  /// The same for the poses that densify() puts between the two.
  [[nodiscard]] bool passes(const Footprint& footprint, const Pose2& from, const Pose2& to) const;
  [[nodiscard]] bool passes(const Pose2& from, const Pose2& to) const { return passes(footprint_, from, to); }

  struct Span {  ///< of poses, both included
    std::size_t first;
    std::size_t last;
  };
  [[nodiscard]] std::optional<Span> last_contact(const Footprint& footprint, const std::vector<Pose2>& poses,
                                                 std::size_t end) const;
  [[nodiscard]] Span widened(const std::vector<Pose2>& poses, const Span& span, double margin_m) const;
  /// A free pose where the footprint has most freedom to rotate, on the line across the path at a pose;
  /// empty: the passage is closed for this footprint.
  [[nodiscard]] std::optional<Pose2> freest_across(const Pose2& pose, double direction) const;
  struct Section {
    bool closed{false};
    Pose2 pose;  ///< closed: the path's; else the one to align with
  };
  /// The narrowest place of a span.
  [[nodiscard]] Section narrowest(const std::vector<Pose2>& poses, const Span& span) const;
  /// A footprint as small as a cell may pass beside the line across, and fits the cells' own lattice.
  [[nodiscard]] bool is_small() const;
  /// Replaces the span in `poses`.
  [[nodiscard]] Status replace(std::vector<Pose2>& poses, const Span& span, Pose2& where) const;
  /// A passage from the first to the last pose of a part of a path; kBlocked: `where` is how far it comes.
  [[nodiscard]] Status search(const std::vector<Pose2>& along, const PoseLattice& lattice,
                              std::vector<Pose2>& passage, Pose2& where) const;
  [[nodiscard]] Status search_steered(const std::vector<Pose2>& along, PoseLattice lattice,
                                      const Section& section, std::vector<Pose2>& passage,
                                      Pose2& where) const;
  /// A differential base's path with straight passages where the footprint has little room.
  [[nodiscard]] std::vector<Pose2> centred(std::vector<Pose2> poses) const;
  [[nodiscard]] std::optional<std::vector<Pose2>> straight_through(const Pose2& first, const Pose2& middle,
                                                                   const Pose2& last) const;
  [[nodiscard]] static std::vector<Pose2> part(const std::vector<Pose2>& poses, const Span& span);
  static void put(std::vector<Pose2>& poses, const Span& span, const std::vector<Pose2>& passage);

  [[nodiscard]] std::vector<Pose2> straightened(const std::vector<Pose2>& poses) const;

  const CostGrid& costs_;
  const Footprint& footprint_;
  std::vector<Footprint> padded_;  ///< of a differential base, widest first; the last one is its own
  const Traversal& traversal_;
  BaseKind base_;
  const PlanClock& clock_;
};

}  // namespace extperfc::navigate
