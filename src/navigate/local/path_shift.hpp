#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "navigate/local/clearance_field.hpp"
#include "navigate/local/path_window.hpp"

namespace extperfc::navigate {

/// Moves the path ahead sideways, by up to `max_shift_m`, and rotates its headings a little, to where the
/// footprint has clearance: the middle of a door that the map shows a little elsewhere, along its walls; the
/// free side of a chair that the map does not show. Least sum over stations by dynamic programming (Viterbi)
/// over shifts of kShiftStep_m and headings of kYawStep_rad. O(stations * shifts * headings).
class PathShift {
 public:
  static constexpr double kShiftStep_m = 0.025;
  static constexpr double kYawStep_rad = 0.07;
  static constexpr int kYawSteps = 2;  ///< to either side

  /// Where the footprint touches: the field's cost map is asked in doubt.
  struct Surroundings {
    const ClearanceField& field;
    const Outline& outline;
    const Footprint& footprint;
    Pose2 robot;  ///< stations are about its position
  };
  struct Limits {
    double max_shift_m{0};
    bool rotates{false};  ///< headings may change: a differential base's follow from its path
  };

  /// Shifts the stations in place and cuts them where no shift passes. Returns the length up to there; empty:
  /// nothing is blocked. `remaining_m` of the path tells shifts of earlier calls from each other; a new path
  /// forgets them.
  std::optional<float> apply(const Surroundings& around, const Limits& limits, double remaining_m,
                             std::vector<Station>& stations);
  void clear() { last_.clear(); }

 private:
  /// From a station's own pose.
  struct Offset {
    float shift_m{0};
    float yaw_rad{0};
  };
  /// Of a layer's states: shifts, and for each of them headings.
  struct States {
    int half_shifts{0};
    int half_yaws{0};
    [[nodiscard]] int shifts() const { return 2 * half_shifts + 1; }
    [[nodiscard]] int yaws() const { return 2 * half_yaws + 1; }
    [[nodiscard]] int count() const { return shifts() * yaws(); }
    [[nodiscard]] Offset offset(int state) const;
  };
  struct Step {
    float cost{0};
    int from{0};
  };

  [[nodiscard]] bool all_clear(const Surroundings& around, const std::vector<Station>& stations) const;
  [[nodiscard]] static float node_cost(const Surroundings& around, const Station& at, const Offset& offset,
                                       double remaining_m);
  [[nodiscard]] Offset last_offset(double remaining_m) const;
  [[nodiscard]] Step best_step(const States& states, std::size_t layer, int state) const;
  std::size_t solve(const Surroundings& around, const std::vector<Station>& stations, const States& states,
                    double remaining_m);
  void trace(const States& states, std::size_t layers);
  void move(std::vector<Station>& stations, double remaining_m);

  std::vector<float> costs_;     ///< of states, layer by layer
  std::vector<int> from_;        ///< best state of the layer before
  std::vector<Offset> offsets_;  ///< of layers
  std::vector<Offset> last_;     ///< of the last call
  double last_remaining_m_{0};   ///< of the first of them
};

}  // namespace extperfc::navigate
