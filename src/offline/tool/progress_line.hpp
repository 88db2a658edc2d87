#pragma once

#include <cstddef>

#include "extperfc/base/stopwatch.hpp"
#include "extperfc/offline/map_recording.hpp"

namespace extperfc::offline {

/// Prints the progress of mapping on standard error: a bar that moves on a terminal, a line for every
/// tenth of the recording elsewhere.
class ProgressLine {
 public:
  ProgressLine();
  void show(const MappingProgress& progress);
  /// Ends the bar's line.
  void end();

 private:
  void show_bar(const MappingProgress& progress);
  void show_line(const MappingProgress& progress);

  Stopwatch since_start_;
  bool terminal_;
  bool bar_shown_{false};
  double next_s_{0};           // the bar moves ten times a second at most
  double next_fraction_{0.1};  // of the next line
};

}  // namespace extperfc::offline
