#pragma once

#include <memory>
#include <stdexcept>

#include <diagnostic_updater/diagnostic_updater.h>
#include <nodelet/nodelet.h>

#include "ros/params/source_params.hpp"
#include "ros/sources/recording_player.hpp"

namespace extperfc {

/// What the nodelets that play recordings share: load parameters, open, play, report.
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
    updater_ =
        std::make_unique<diagnostic_updater::Updater>(getNodeHandle(), getPrivateNodeHandle(), getName());
    updater_->setHardwareID("none");
    updater_->add("source",
                  [this](diagnostic_updater::DiagnosticStatusWrapper& status) { player_->report(status); });
    timer_ =
        getNodeHandle().createWallTimer(ros::WallDuration(0.2), [this](const auto&) { updater_->update(); });
  }

  [[noreturn]] void give_up(const Error& error) {
    NODELET_FATAL("%s", error.message.c_str());
    throw std::runtime_error(error.message);
  }

  std::unique_ptr<RecordingPlayer> player_;
  std::unique_ptr<diagnostic_updater::Updater> updater_;
  ros::WallTimer timer_;
};

}  // namespace extperfc
