#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/navigate/velocity.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// Where velocity commands come from, e.g. a joystick.
struct VelocitySource {
  std::string name;
  int priority{0};        ///< the source with the largest one that is not silent has the base
  double timeout_s{0.5};  ///< silence after which it gives the base away, (0, 60]
};

/// What goes to the base now.
struct MuxedVelocity {
  Twist2 velocity;
  std::optional<std::size_t> source{};  ///< index; empty: stopped, or every source is silent
};

/// Decides whose velocity the base gets: the emergency stop, else the source of largest priority that is not
/// silent. Every command is limited. When the last source falls silent, zero is sent once, and no more
/// afterwards, so that another program may drive the base. Time is any clock's; one that runs back makes
/// every source silent. One thread at a time.
class VelocityMux {
 public:
  /// Errors: no source, more than 100, a name or a priority twice, a timeout out of its range, bad limits.
  [[nodiscard]] static Result<VelocityMux> make(std::vector<VelocitySource> sources,
                                                const VelocityLimits& limits);

  /// False: the velocity is not finite, and was ignored. Precondition: source < sources().size().
  bool command(std::size_t source, const Twist2& velocity, double now_s);
  /// Zero is sent as long as the emergency stop is on.
  void set_stop(bool on) { stop_ = on; }
  /// Sources with a priority below this have no effect. std::nullopt: no lock.
  void set_lock(std::optional<int> priority) { lock_ = priority; }

  /// What to send now. Empty: nothing is to be sent.
  [[nodiscard]] std::optional<MuxedVelocity> output(double now_s);

  [[nodiscard]] const std::vector<VelocitySource>& sources() const { return sources_; }
  [[nodiscard]] bool stopped() const { return stop_; }
  [[nodiscard]] std::optional<int> lock() const { return lock_; }
  /// Whose turn it is; empty when all are silent or locked out.
  [[nodiscard]] std::optional<std::size_t> active(double now_s) const;

 private:
  struct Command {
    Twist2 velocity;
    double stamp_s{-std::numeric_limits<double>::infinity()};
  };

  VelocityMux(std::vector<VelocitySource> sources, const VelocityLimits& limits);
  [[nodiscard]] bool speaks(std::size_t source, double now_s) const;

  std::vector<VelocitySource> sources_;
  VelocityLimits limits_;
  std::vector<Command> commands_;
  bool stop_{false};
  std::optional<int> lock_;
  bool sending_{false};  ///< the last output was not the final zero
};

}  // namespace extperfc::navigate
