#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "extperfc/translate/event_loop.hpp"

namespace extperfc::translate {

/// Our wall clock [s since 1970], and what it showed at a moment of the steady clock.
[[nodiscard]] double wall_clock_s();
[[nodiscard]] double wall_clock_s(SteadyTime moment);

/// How far the robot's clock is ahead of ours: offset = robot clock - our clock, in seconds, from two kinds
/// of measurements. Times are seconds since 1970 of the named clock. One thread; bounded memory; O(1) per
/// sample.
///
/// Stamps: a message stamped `stamp` by the robot's clock and received at `receive` by ours took a delay that
/// is not negative, so stamp - receive = offset - delay is a LOWER bound of the offset. The largest one of a
/// sliding window belongs to the shortest delay, and is the estimate. It is too low by that shortest delay:
/// stamps that are shifted with it, in either direction, never lie in the receiver's future.
///
/// NTP: offset = ((t1 - t0) + (t2 - t3)) / 2, wrong by half the round trip (t3 - t0) - (t2 - t1) at most (RFC
/// 5905, section 8). The sample of the smallest bound counts; the bound grows with age as clocks drift.
///
/// Steps: a clock that jumps makes samples that disagree with the window. A few that agree among themselves
/// begin a new window; a single outlier does not.
class ClockOffset {
 public:
  struct Params {
    double window_s{10.0};  ///< of stamps, [0.1, 3600]
    double step_s{0.05};    ///< disagreement above is a step of a clock, or an outlier
    double settle_s{
        2.0};  ///< stamps that are late by the same amount for this time indicate a step, not a jam
    double drift{50e-6};        ///< of two clocks against each other at most [s/s]: two plain quartz crystals
    double ntp_valid_s{300.0};  ///< NTP is preferred while its last sample is younger
    double longest_trip_s{5.0};  ///< NTP samples with a longer round trip are not used
  };
  enum class Source : std::uint8_t { kStamps, kNtp };
  struct Estimate {
    double offset_s{0};
    /// NTP: bound of the error in both directions. Stamps: the offset may be larger by the shortest delay,
    /// which cannot be seen; this is the mean excess of the others over it, which is of its size on usual
    /// networks.
    double uncertainty_s{0};
    Source source{Source::kStamps};
    double age_s{0};  ///< of the newest sample that counted
  };

  ClockOffset() : ClockOffset(Params{}) {}
  explicit ClockOffset(Params params);

  /// Stamps of 0 (not set), and what is not finite, do not count.
  void add_stamp_sample(double receive_time_s, double stamp_s);
  /// t0: our clock when the request left; t1, t2: the robot's clock when it came and when the answer left;
  /// t3: ours when that came. Samples that no order of events can make do not count.
  void add_ntp_sample(double t0, double t1, double t2, double t3);

  /// Nothing before the first kAgree stamps or the first NTP sample. Stays, and ages, when samples stop.
  [[nodiscard]] std::optional<Estimate> estimate(double now_s = wall_clock_s()) const;
  /// Steps of a clock that were noticed.
  [[nodiscard]] std::uint64_t steps() const { return steps_; }

  static constexpr std::size_t kAgree = 5;  ///< stamps that begin a window

 private:
  /// Differences (stamp - receive) of one stretch of time.
  struct Span {
    double best{0}, worst{0}, sum{0};
    double first_s{0}, last_s{0};  ///< receive times
    std::size_t count{0};
    void add(double receive_s, double difference_s);
    void add(const Span& other);
  };
  struct NtpSample {
    double offset_s{0}, bound_s{0}, time_s{0};
    [[nodiscard]] double bound_at(double now_s, double drift) const;
  };
  static constexpr std::size_t kSlots = 20;   ///< of a window: so it slides by a twentieth
  static constexpr std::size_t kNtpKept = 8;  ///< as RFC 5905's clock filter

  void slide_to(double receive_s);
  void add_to_run(double receive_s, double difference_s);
  [[nodiscard]] bool run_is_step() const;
  void begin_window_with_run();
  void forget_stamps();
  [[nodiscard]] Span window() const;
  [[nodiscard]] std::optional<double> reference() const;
  [[nodiscard]] const NtpSample* best_ntp(double now_s) const;
  [[nodiscard]] std::optional<Estimate> from_stamps(double now_s) const;
  [[nodiscard]] std::optional<Estimate> from_ntp(double now_s) const;

  Params params_;
  std::array<Span, kSlots> slots_{};
  std::int64_t newest_slot_{0};
  std::optional<double> newest_receive_s_;
  Span held_;  ///< what the window was before it ran empty
  Span run_;   ///< the latest samples that disagree with the window and agree among themselves
  std::optional<double> disagreeing_since_s_;  ///< no sample agreed with the window since
  std::deque<NtpSample> ntp_;
  std::optional<NtpSample> disagreeing_ntp_;
  std::uint64_t steps_{0};
};

}  // namespace extperfc::translate
