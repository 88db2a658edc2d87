#include "extperfc/translate/clock_offset.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace extperfc::translate {

namespace {

/// Receive times that go back by more than this are another setting of our clock.
constexpr double kBackwardsS = 1.0;
/// No clock is read finer over a network; keeps a lone sample's uncertainty from being 0.
constexpr double kMinUncertaintyS = 1e-3;
/// ROS stamps have 32 bits of seconds.
constexpr double kLastStampS = 4294967296.0;

}  // namespace

ClockOffset::ClockOffset(Params params) : params_(params) {
  constexpr double kMinWindowS = 0.1;
  params_.window_s = std::max(params_.window_s, kMinWindowS);
}

double wall_clock_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

double wall_clock_s(SteadyTime moment) {
  return wall_clock_s() - std::chrono::duration<double>(EventLoop::now() - moment).count();
}

void ClockOffset::Span::add(double receive_s, double difference_s) {
  add(Span{difference_s, difference_s, difference_s, receive_s, receive_s, 1});
}

void ClockOffset::Span::add(const Span& other) {
  if (other.count == 0) return;
  if (count == 0) {
    *this = other;
    return;
  }
  best = std::max(best, other.best);
  worst = std::min(worst, other.worst);
  sum += other.sum;
  first_s = std::min(first_s, other.first_s);
  last_s = std::max(last_s, other.last_s);
  count += other.count;
}

double ClockOffset::NtpSample::bound_at(double now_s, double drift) const {
  return bound_s + drift * std::max(0.0, now_s - time_s);
}

void ClockOffset::add_stamp_sample(double receive_time_s, double stamp_s) {
  const auto is_time = [](double time_s) { return time_s > 0.0 && time_s < kLastStampS; };  // false for NaN
  if (!is_time(receive_time_s) || !is_time(stamp_s)) return;
  if (newest_receive_s_ && receive_time_s < *newest_receive_s_ - kBackwardsS) {
    forget_stamps();
    ++steps_;
  }
  const double receive_s = std::max(receive_time_s, newest_receive_s_.value_or(receive_time_s));
  const double difference_s = stamp_s - receive_time_s;
  slide_to(receive_s);
  newest_receive_s_ = receive_s;
  const auto expected = reference();
  if (expected && std::abs(difference_s - *expected) <= params_.step_s) {
    run_ = Span{};
    disagreeing_since_s_.reset();
    slots_[static_cast<std::size_t>(newest_slot_ % kSlots)].add(receive_s, difference_s);
    return;
  }
  add_to_run(receive_s, difference_s);
  if (run_is_step()) begin_window_with_run();
}

/// Empties the slots that have left the window.
void ClockOffset::slide_to(double receive_s) {
  const auto slot = static_cast<std::int64_t>(std::floor(receive_s / params_.window_s * kSlots));
  if (const auto before = window(); before.count > 0) held_ = before;
  const auto passed = std::min<std::int64_t>(slot - newest_slot_, kSlots);
  for (std::int64_t i = 0; i < passed; ++i) slots_[static_cast<std::size_t>((slot - i) % kSlots)] = Span{};
  newest_slot_ = slot;
}

/// A run's samples agree among themselves: one that does not begins another run.
void ClockOffset::add_to_run(double receive_s, double difference_s) {
  if (!disagreeing_since_s_) disagreeing_since_s_ = receive_s;
  if (run_.count > 0 && std::abs(difference_s - run_.best) > params_.step_s) run_ = Span{};
  run_.add(receive_s, difference_s);
}

/// Stamps later than the window allows are no delay, so a few prove a step. Earlier ones may be late by the
/// queue of a jammed network: they must all be so by the same, for a while. When nothing agrees with anything
/// for as long as the window, what it held no longer counts.
bool ClockOffset::run_is_step() const {
  if (run_.last_s - *disagreeing_since_s_ >= params_.window_s) return true;
  if (run_.count < kAgree) return false;
  const auto expected = reference();
  return !expected || run_.best > *expected || run_.last_s - run_.first_s >= params_.settle_s;
}

void ClockOffset::begin_window_with_run() {
  const Span run = run_;
  const bool is_step = reference().has_value();
  const auto newest = newest_receive_s_;
  const auto slot = newest_slot_;
  forget_stamps();
  newest_receive_s_ = newest;
  newest_slot_ = slot;
  slots_[static_cast<std::size_t>(slot % kSlots)] = run;
  if (is_step) ++steps_;
}

void ClockOffset::forget_stamps() {
  slots_.fill(Span{});
  held_ = Span{};
  run_ = Span{};
  disagreeing_since_s_.reset();
  newest_receive_s_.reset();
}

ClockOffset::Span ClockOffset::window() const {
  Span all;
  for (const auto& slot : slots_) all.add(slot);
  return all;
}

std::optional<double> ClockOffset::reference() const {
  const auto all = window();
  if (all.count > 0) return all.best;
  if (held_.count > 0) return held_.best;
  return std::nullopt;
}

void ClockOffset::add_ntp_sample(double t0, double t1, double t2, double t3) {
  const double trip_s = (t3 - t0) - (t2 - t1);
  const double offset_s = ((t1 - t0) + (t2 - t3)) / 2;
  const bool possible = std::isfinite(trip_s) && t3 >= t0 && t2 >= t1 && trip_s >= 0.0;
  if (!possible || trip_s > params_.longest_trip_s) return;
  const NtpSample sample{offset_s, trip_s / 2, t3};
  const auto agrees = [&](const NtpSample& other) {
    return std::abs(other.offset_s - offset_s) <=
           other.bound_at(t3, params_.drift) + sample.bound_s + params_.step_s;
  };
  if (!ntp_.empty() && t3 < ntp_.back().time_s - kBackwardsS) ntp_.clear();
  if (const auto* best = best_ntp(t3); best != nullptr && !agrees(*best)) {
    if (!disagreeing_ntp_ || !agrees(*disagreeing_ntp_)) {
      disagreeing_ntp_ = sample;
      return;
    }
    ntp_.clear();
    ntp_.push_back(*disagreeing_ntp_);
    ++steps_;
  }
  disagreeing_ntp_.reset();
  ntp_.push_back(sample);
  if (ntp_.size() > kNtpKept) ntp_.pop_front();
}

const ClockOffset::NtpSample* ClockOffset::best_ntp(double now_s) const {
  const auto best = std::min_element(ntp_.begin(), ntp_.end(), [&](const auto& a, const auto& b) {
    return a.bound_at(now_s, params_.drift) < b.bound_at(now_s, params_.drift);
  });
  return best == ntp_.end() ? nullptr : &*best;
}

std::optional<ClockOffset::Estimate> ClockOffset::from_stamps(double now_s) const {
  auto all = window();
  if (all.count == 0) all = held_;
  if (all.count == 0) return std::nullopt;
  const double excess_s = all.best - all.sum / static_cast<double>(all.count);
  const double age_s = std::max(0.0, now_s - all.last_s);
  return Estimate{all.best, std::max(excess_s, kMinUncertaintyS) + params_.drift * age_s, Source::kStamps,
                  age_s};
}

std::optional<ClockOffset::Estimate> ClockOffset::from_ntp(double now_s) const {
  const auto* best = best_ntp(now_s);
  if (best == nullptr) return std::nullopt;
  return Estimate{best->offset_s, best->bound_at(now_s, params_.drift), Source::kNtp,
                  std::max(0.0, now_s - ntp_.back().time_s)};
}

std::optional<ClockOffset::Estimate> ClockOffset::estimate(double now_s) const {
  const auto stamps = from_stamps(now_s);
  const auto ntp = from_ntp(now_s);
  if (!ntp || (stamps && ntp->age_s > params_.ntp_valid_s)) return stamps;
  return ntp;
}

}  // namespace extperfc::translate
