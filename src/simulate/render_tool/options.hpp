#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc::simulate {

/// Which random worlds are drawn.
enum class Scenes {
  kOrdinary,  ///< a table in a room, as a robot meets it
  kVaried,    ///< any look, any pose, look-alikes, odd light, a poor camera
  kMixed      ///< both in turn
};

struct Options {
  std::filesystem::path out;
  int count{100};  ///< images, [1, 999999]
  std::uint64_t seed{1};
  int width{640};               ///< [64, 4096]
  int height{480};              ///< [64, 4096]
  std::filesystem::path world;  ///< empty: random worlds
  Scenes scenes{Scenes::kOrdinary};
  int supersampling{2};  ///< 1 or 2
  bool sequence{false};  ///< a recording of a moving camera instead of single images
  bool depth{false};
  bool plain{false};  ///< without the lens and sensor effects
  bool resume{false};
  int threads{0};            ///< 0: one per processor
  int min_pixels{40};        ///< visible pixels of an object that gets a box
  double max_distance_m{0};  ///< of the camera from an object, [0.4, 10]; 0: that of the scenes
  double val{0.1};           ///< fraction of the worlds that go to val.txt, [0, 1]
  std::vector<std::string> classes{"cone", "cube", "sphere"};
  bool help{false};
};

extern const char* const kHelp;

/// From the arguments behind the program's name. Errors: unknown option, value missing or out of its range.
[[nodiscard]] Result<Options> parse_options(const std::vector<std::string>& arguments);

/// What decides about the images, as text: two runs with the same text write the same files.
/// Reads the world's file.
[[nodiscard]] std::string fingerprint(const Options& options);

}  // namespace extperfc::simulate
