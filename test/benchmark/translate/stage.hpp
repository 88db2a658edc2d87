#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "test/benchmark/translate/blob.hpp"
#include "test/benchmark/translate/process.hpp"

namespace extperfc::benchmark {

/// Two masters and a folder of our own, on the loopback interface. Sets the environment of ROS for this
/// process and those it starts: make it before anything else.
class Stage {
 public:
  [[nodiscard]] static Result<Stage> make();
  Stage(Stage&&) = default;
  Stage& operator=(Stage&&) = default;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;
  ~Stage();

  [[nodiscard]] const std::string& robot_uri() const { return uris_[0]; }
  [[nodiscard]] const std::string& workstation_uri() const { return uris_[1]; }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  [[nodiscard]] const Definitions& definitions() const { return definitions_; }

 private:
  Stage() = default;
  [[nodiscard]] Result<void> start_master();

  std::filesystem::path folder_;
  Definitions definitions_;
  std::vector<std::string> uris_;
  std::vector<Process> masters_;
};

}  // namespace extperfc::benchmark
