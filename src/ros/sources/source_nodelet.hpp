#pragma once

#include <memory>
#include <optional>
#include <stdexcept>

#include <nodelet/nodelet.h>

#include "ros/health/reporter.hpp"
#include "ros/params/source_params.hpp"
#include "ros/sources/recording_player.hpp"

namespace extperfc::ros_sources {

/// Common part of the nodelets that play recordings: load parameters, open, play, report.
class SourceNodelet : public nodelet::Nodelet {
 protected:
  [[nodiscard]] virtual Result<std::unique_ptr<sources::Recording>> open(
      const ros_params::SourceParams& params) = 0;

 private:
  void onInit() override {
    auto params = ros_params::load_source_params(getPrivateNodeHandle());
    if (!params) give_up(params.error());
    auto recording = open(*params);
    if (!recording) give_up(recording.error());
    NODELET_INFO("%s: %zu frames", params->path.c_str(), (*recording)->size());
    player_ = std::make_unique<RecordingPlayer>(getNodeHandle(), *params, std::move(*recording));
    reporter_.emplace(getNodeHandle(), getPrivateNodeHandle(), getName());
    reporter_->add("source", [this](auto& status) { player_->report(status); });
    reporter_->start();
  }

  [[noreturn]] void give_up(const Error& error) {
    NODELET_FATAL("%s", error.message.c_str());
    throw std::runtime_error(error.message);
  }

  std::unique_ptr<RecordingPlayer> player_;
  std::optional<ros_health::Reporter> reporter_;  ///< last: it asks the player
};

}  // namespace extperfc::ros_sources
