#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "test/benchmark/localize/halves.hpp"
#include "test/benchmark/localize/subject.hpp"

namespace extperfc::benchmark {

/// What a filter made of one update.
struct Outcome {
  bool known{true};  ///< on known ground
  bool right{false};
  double off_m{0};
  double off_deg{0};
  bool certain{false};  ///< it reports at most 0.2 m of standard deviation (the node's default to warn)
  Pose2 pose;
  Pose2 truth;

  [[nodiscard]] bool falsely_certain() const { return certain && off_m > 1; }
};

/// Runs the updates from `first` to before `end`.
[[nodiscard]] std::vector<Outcome> follow(Subject& subject, const HalfCase& half,
                                          const std::vector<Step>& steps, std::size_t first, std::size_t end);

/// More than five successive updates on known ground that are not right.
struct Loss {
  std::size_t first{0};                ///< update
  bool on_return{false};               ///< the robot came back from unknown ground with it
  std::optional<std::size_t> updates;  ///< on known ground until right again; none: not to the end
};
[[nodiscard]] std::vector<Loss> find_losses(const std::vector<Outcome>& outcomes);

/// Updates until right to stay: the number of the first one from which on all are right, which must be at
/// least the last ten. None: not found.
[[nodiscard]] std::optional<std::size_t> updates_until_right(const std::vector<Outcome>& outcomes);

/// The robot is followed over kFollowed updates from `from` on and carried to `to`, without odometry's
/// knowledge.
struct Kidnap {
  std::size_t from{0};  ///< steps
  std::size_t to{0};
  std::uint64_t seed{1};  ///< of the noise of a scanner that stands
};
constexpr std::size_t kFollowed = 20;  ///< updates before the robot is carried away
constexpr std::size_t kWindow = 30;    ///< updates of a trial on the move
constexpr std::size_t kStanding = 60;  ///< updates of a trial of a robot that stands

/// `count` pairs of starts that lie at least 3 m apart; fewer where there are none.
[[nodiscard]] std::vector<Kidnap> draw_kidnaps(const HalfCase& half, const std::vector<Step>& steps,
                                               std::size_t count, std::uint64_t seed);

/// It drives on there as the log does. The outcomes begin at the new place.
[[nodiscard]] std::vector<Outcome> kidnap_driving(Subject& subject, const HalfCase& half,
                                                  const std::vector<Step>& steps, const Kidnap& kidnap);
/// It stands there: the same scan with noise of 1 cm.
[[nodiscard]] std::vector<Outcome> kidnap_standing(Subject& subject, const HalfCase& half,
                                                   const std::vector<Step>& steps, const Kidnap& kidnap);

}  // namespace extperfc::benchmark
