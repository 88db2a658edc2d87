#pragma once

#include <optional>
#include <vector>

#include "navigate/local/clearance_field.hpp"
#include "navigate/local/path_window.hpp"

namespace extperfc::navigate {

/// Moves the path ahead sideways, by up to `max_shift_m`, to where the footprint has clearance: the middle of
/// a door that the map shows a little elsewhere, the free side of a chair that the map does not show. Least
/// sum over stations by dynamic programming (Viterbi) over shifts of kShiftStep_m.
class PathShift {
 public:
  static constexpr double kShiftStep_m = 0.025;

  /// Where the footprint touches: the field's cost map is asked in doubt.
  struct Surroundings {
    const ClearanceField& field;
    const Outline& outline;
    const Footprint& footprint;
    Pose2 robot;  ///< stations are about its position
  };

  /// Shifts the stations in place and cuts them where no shift passes. Returns the length up to there; empty:
  /// nothing is blocked. `travelled_m` tells shifts of earlier calls from each other; a new path forgets
  /// them.
  std::optional<float> apply(const Surroundings& around, double max_shift_m, double travelled_m,
                             std::vector<Station>& stations);
  void clear() { last_.clear(); }

 private:
  [[nodiscard]] bool all_clear(const Surroundings& around, const std::vector<Station>& stations) const;
  [[nodiscard]] static float node_cost(const Surroundings& around, const Station& at, float shift_m,
                                       double remaining_m);
  [[nodiscard]] float last_shift(double remaining_m) const;
  std::size_t solve(const Surroundings& around, const std::vector<Station>& stations, int half,
                    double remaining_m);
  void trace(std::size_t layers, int half);
  void move(std::vector<Station>& stations, double remaining_m);

  std::vector<float> costs_;    ///< of states, layer by layer
  std::vector<int> from_;       ///< best state of the layer before
  std::vector<float> shifts_;   ///< of layers [m]
  std::vector<float> last_;     ///< shifts of the last call [m]
  double last_remaining_m_{0};  ///< of the first of them
};

}  // namespace extperfc::navigate
