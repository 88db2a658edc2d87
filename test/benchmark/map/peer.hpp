#pragma once

#include <cstddef>
#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/map/child.hpp"
#include "test/benchmark/map/drive.hpp"

namespace extperfc::benchmark {

/// A mapper of MRPT with a configuration that MRPT ships.
struct PeerProgram {
  const char* name;           ///< for people
  const char* program;        ///< rbpf-slam or icp-slam
  const char* configuration;  ///< file in MRPT's folder of configurations
};

/// rbpf-slam by ICP on point maps (the configuration for the Intel log), by ICP on grid maps and by optimal
/// sampling, and icp-slam with the best of its configurations.
[[nodiscard]] const std::vector<PeerProgram>& peer_programs();

struct PeerRun {
  std::size_t scans{0};  ///< at most, that the peer was given
  Figures figures;
};

/// One of MRPT's programs over the first scans of a recording, without windows, images and logs; over fewer
/// scans where it would take more than ten minutes of CPU: then over the longest first part that it does in
/// that time. Figures: cpu_s, peak_mb, those of add_score(), and of rbpf-slam filter_steps. Scans between its
/// filter's steps get odometry's motion. Errors: the program or its configuration is missing, or it failed.
[[nodiscard]] Result<PeerRun> run_peer(const PeerProgram& peer, const Recording& recording,
                                       std::size_t scans);

/// Odometry alone over the first scans. Figures: those of add_score().
[[nodiscard]] Result<Figures> run_odometry(const Recording& recording, std::size_t scans);

}  // namespace extperfc::benchmark
