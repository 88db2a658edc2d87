#pragma once

#include <cstddef>

#include "extperfc/base/error.hpp"

#include "test/benchmark/map/child.hpp"
#include "test/benchmark/map/drive.hpp"

namespace extperfc::benchmark {

/// MRPT's rbpf-slam over the first scans of a recording: its shipped ICP-based configuration for the Intel
/// log (10 particles), without windows, images and logs. Figures: as of run_log(), as far as they can be
/// had: scans, cpu_s, peak_mb, filter_steps, relations, translation_m, rotation_deg, worst_loop_m. Scans
/// between its filter's steps get odometry's motion. Errors: the program or its configuration is missing, or
/// it failed.
[[nodiscard]] Result<Figures> run_peer(const Recording& recording, std::size_t scans);

constexpr int kPeerParticles = 10;
constexpr char kPeerName[] = "MRPT rbpf-slam";

}  // namespace extperfc::benchmark
