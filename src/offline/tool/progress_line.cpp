#include "offline/tool/progress_line.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>

#include <unistd.h>

namespace extperfc::offline {

ProgressLine::ProgressLine() : terminal_(isatty(STDERR_FILENO) != 0) {}

void ProgressLine::show(const MappingProgress& progress) {
  if (terminal_)
    show_bar(progress);
  else
    show_line(progress);
}

void ProgressLine::show_bar(const MappingProgress& progress) {
  const double now_s = since_start_.seconds();
  if (now_s < next_s_) return;
  constexpr double kPeriodS = 0.1;
  next_s_ = now_s + kPeriodS;
  constexpr double kWidth = 30;
  const auto filled = static_cast<std::size_t>(kWidth * progress.fraction);
  std::string bar(filled, '#');
  bar.resize(static_cast<std::size_t>(kWidth), '.');
  std::cerr << "\r[" << bar << "] " << std::lround(100 * progress.fraction) << " %  " << progress.scans
            << " scans";
  constexpr double kMinFractionForEstimate = 0.02;
  if (progress.fraction > kMinFractionForEstimate)
    std::cerr << "  " << std::lround(now_s / progress.fraction * (1 - progress.fraction)) << " s to go";
  std::cerr << "\033[K" << std::flush;
  bar_shown_ = true;
}

void ProgressLine::show_line(const MappingProgress& progress) {
  if (progress.fraction < next_fraction_) return;
  constexpr double kStep = 0.1;
  next_fraction_ = (std::floor(progress.fraction / kStep) + 1) * kStep;
  std::cerr << std::lround(100 * progress.fraction) << " %, " << progress.scans << " scans, "
            << std::lround(since_start_.seconds()) << " s\n";
}

void ProgressLine::end() {
  if (bar_shown_) std::cerr << "\r\033[K" << std::flush;
  bar_shown_ = false;
}

}  // namespace extperfc::offline
