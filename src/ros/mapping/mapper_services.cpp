#include "ros/mapping/mapper_services.hpp"

#include <filesystem>
#include <iomanip>
#include <sstream>
#include <system_error>
#include <utility>

#include <ros/console.h>

#include "extperfc/sources/mrpt_map.hpp"
#include "extperfc/world/map_file.hpp"

#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_mapping {

namespace {

namespace fs = std::filesystem;

constexpr double kSettlingPatienceS = 10.0;
constexpr double kJoinPeriodS = 1.0;
constexpr const char* kSessionSuffix = ".session";

template <typename Response>
void answer(const Result<std::string>& result, Response& response) {
  response.success = static_cast<unsigned char>(result.has_value());
  response.message = result ? *result : result.error().message;
}

/// Renames a finished file, so that no reader sees an incomplete one.
Result<void> put_in_place(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (!error) return {};
  std::error_code ignored;
  fs::remove(from, ignored);
  return fail(ErrorCode::kFailed, "cannot write " + to.string() + ": " + error.message());
}

}  // namespace

MapperServices::MapperServices(ros::NodeHandle handle, ros::NodeHandle private_handle,
                               const mapping::MapperParams& params, std::string map_frame,
                               SharedMapper& mapper, MapPublisher& maps, Callbacks callbacks)
    : params_(params),
      map_frame_(std::move(map_frame)),
      mapper_(mapper),
      maps_(maps),
      callbacks_(std::move(callbacks)) {
  handle.setCallbackQueue(&queue_);
  private_handle.setCallbackQueue(&queue_);
  servers_.push_back(handle.advertiseService("dynamic_map", &MapperServices::dynamic_map, this));
  servers_.push_back(private_handle.advertiseService("save_map", &MapperServices::save_map, this));
  servers_.push_back(private_handle.advertiseService("optimize", &MapperServices::optimize, this));
  servers_.push_back(private_handle.advertiseService("load_session", &MapperServices::load_session, this));
  servers_.push_back(
      private_handle.advertiseService("set_localization", &MapperServices::set_localization, this));
  servers_.push_back(private_handle.advertiseService("pause", &MapperServices::pause, this));
  servers_.push_back(private_handle.advertiseService("resume", &MapperServices::resume, this));
  servers_.push_back(private_handle.advertiseService("reset", &MapperServices::reset, this));
  initial_pose_subscriber_ = handle.subscribe("initialpose", 2, &MapperServices::put_at, this);
  join_timer_ = private_handle.createWallTimer(ros::WallDuration(kJoinPeriodS),
                                               [this](const ros::WallTimerEvent&) { join_parts(); });
  spinner_.start();
}

void MapperServices::stop() {
  join_timer_.stop();
  initial_pose_subscriber_.shutdown();
  for (auto& server : servers_) server.shutdown();
  spinner_.stop();
}

bool MapperServices::dynamic_map(nav_msgs::GetMap::Request& /*request*/,
                                 nav_msgs::GetMap::Response& response) {
  if (maps_.current(response.map)) return true;
  ROS_WARN("dynamic_map: there is no map yet: no scan was used");
  return false;
}

bool MapperServices::save_map(SaveMap::Request& request, SaveMap::Response& response) {
  answer(save(request.path), response);
  return true;
}

Result<std::string> MapperServices::save(const std::string& path) {
  if (path.empty() || fs::path(path).filename().empty())
    return fail(
        ErrorCode::kInvalidArgument,
        "path must name a file without its suffix, /home/robot/maps/office for instance, not '" + path + "'");
  std::error_code error;
  const fs::path stem = fs::absolute(path, error);
  search_for_loops();
  const auto map = maps_.settled_map(kSettlingPatienceS);
  if (!map) return fail(ErrorCode::kNotFound, "there is no map yet: no scan was used");
  if (sources::names_gridmap(stem)) {
    const auto saved = sources::save_gridmap(*map, stem);
    return saved ? Result<std::string>("wrote " + stem.string()) : tl::unexpected(saved.error());
  }
  if (const auto saved = extperfc::save_map(*map, stem); !saved) return tl::unexpected(saved.error());
  const fs::path session = stem.string() + kSessionSuffix;
  const fs::path unfinished = session.string() + ".part";
  const auto saved = mapper_.with([&](const mapping::Mapper& mapper) { return mapper.save(unfinished); });
  if (!saved) return tl::unexpected(saved.error());
  if (const auto placed = put_in_place(unfinished, session); !placed) return tl::unexpected(placed.error());
  return "wrote " + stem.string() + ".pgm, .yaml and " + kSessionSuffix;
}

/// Mapping goes on meanwhile. A map that was replaced by another one stays as it is.
void MapperServices::search_for_loops() {
  auto search = mapper_.with([](const mapping::Mapper& mapper) { return mapper.search(); });
  search.run();
  mapper_.with([&](mapping::Mapper& mapper) { return mapper.adopt(std::move(search)); });
}

/// After a robot was carried, whenever it has seen enough of where it is now.
void MapperServices::join_parts() {
  if (!mapper_.with([](const mapping::Mapper& mapper) { return mapper.wants_search(); })) return;
  search_for_loops();
  const auto parts = mapper_.with([](const mapping::Mapper& mapper) { return mapper.statistics().parts; });
  if (parts == 1) ROS_INFO("a place was recognized: the map is one again");
}

/// rviz' "2D Pose Estimate". A covariance of zero means what rviz sends by itself.
void MapperServices::put_at(const geometry_msgs::PoseWithCovarianceStamped& message) {
  constexpr double kUsualM = 0.5;
  constexpr double kUsualRad = 0.25;
  if (ros_convert::without_slash(message.header.frame_id) != map_frame_) {
    ROS_WARN("ignoring initial pose: its frame is '%s', not '%s'", message.header.frame_id.c_str(),
             map_frame_.c_str());
    return;
  }
  Eigen::Matrix3d covariance = ros_convert::to_covariance(message.pose.covariance);
  if (covariance.isZero())
    covariance = Eigen::Vector3d(kUsualM * kUsualM, kUsualM * kUsualM, kUsualRad * kUsualRad).asDiagonal();
  const auto pose = ros_convert::to_pose2(message.pose.pose);
  const auto put =
      pose ? mapper_.with([&](mapping::Mapper& mapper) { return mapper.put_at(*pose, covariance); })
           : Result<void>(tl::unexpected(pose.error()));
  if (!put)
    ROS_WARN("ignoring initial pose: %s", put.error().message.c_str());
  else
    ROS_INFO("the robot was put at %.2f %.2f m, %.2f rad", pose->x, pose->y, pose->yaw);
}

bool MapperServices::optimize(Trigger::Request& /*request*/, Trigger::Response& response) {
  search_for_loops();
  const auto statistics = mapper_.with([](const mapping::Mapper& mapper) { return mapper.statistics(); });
  if (statistics.key_frames == 0) {
    answer(tl::unexpected(Error{ErrorCode::kNotFound, "there is no map yet: no scan was used"}), response);
    return true;
  }
  (void)maps_.settled_map(kSettlingPatienceS);
  std::ostringstream text;
  text << "searched " << statistics.key_frames << " key frames for loops; the position is known to "
       << std::setprecision(2) << statistics.position_sigma_m << " m";
  if (statistics.parts > 1) text << "; " << statistics.parts << " parts of the map are not joined yet";
  answer(text.str(), response);
  return true;
}

bool MapperServices::load_session(LoadSession::Request& request, LoadSession::Response& response) {
  auto loaded = request.path.empty()
                    ? Result<mapping::Mapper>(
                          fail(ErrorCode::kInvalidArgument, "path must name a session that save_map wrote"))
                    : mapping::Mapper::load(request.path, params_);
  if (!loaded) {
    answer(tl::unexpected(loaded.error()), response);
    return true;
  }
  (void)loaded->set_mode(mapper_.with([](const mapping::Mapper& mapper) { return mapper.mode(); }));
  mapper_.replace(std::move(*loaded));
  callbacks_.restarted();
  answer("resumed from " + request.path, response);
  return true;
}

bool MapperServices::set_localization(std_srvs::SetBool::Request& request,
                                      std_srvs::SetBool::Response& response) {
  const bool localize = request.data != 0;
  const auto set = mapper_.with([&](mapping::Mapper& mapper) {
    return mapper.set_mode(localize ? mapping::MapperMode::kLocalization : mapping::MapperMode::kMapping);
  });
  answer(set ? Result<std::string>(localize ? "localizing: the map stays as it is" : "mapping")
             : Result<std::string>(tl::unexpected(set.error())),
         response);
  return true;
}

bool MapperServices::pause(Trigger::Request& /*request*/, Trigger::Response& response) {
  callbacks_.pause(true);
  answer(std::string("paused: scans are skipped"), response);
  return true;
}

bool MapperServices::resume(Trigger::Request& /*request*/, Trigger::Response& response) {
  callbacks_.pause(false);
  answer(std::string("mapping"), response);
  return true;
}

bool MapperServices::reset(Trigger::Request& /*request*/, Trigger::Response& response) {
  auto fresh = mapping::Mapper::make(params_);
  if (!fresh) {
    answer(tl::unexpected(fresh.error()), response);
    return true;
  }
  mapper_.replace(std::move(*fresh));
  callbacks_.restarted();
  answer(std::string("the next scan starts a new map"), response);
  return true;
}

}  // namespace extperfc::ros_mapping
