#include "ros/params/read_footprint.hpp"

#include <exception>
#include <optional>

#include <yaml-cpp/yaml.h>

#include "ros/params/list_reader.hpp"

namespace extperfc::ros_params {

namespace {

using Corners = std::vector<Eigen::Vector2d>;

std::optional<Corners> corners_of_text(const std::string& text) {
  Corners corners_m;
  try {
    for (const auto& corner : YAML::Load(text)) {
      if (corner.size() != 2) return std::nullopt;
      corners_m.emplace_back(corner[0].as<double>(), corner[1].as<double>());
    }
  } catch (const std::exception&) {
    return std::nullopt;
  }
  return corners_m;
}

std::optional<Corners> corners_of_list(XmlRpc::XmlRpcValue& list) {
  constexpr Range<double> kRange{-10, 10};
  Corners corners_m;
  try {
    for (int i = 0; i < list.size(); ++i) {
      if (list[i].size() != 2) return std::nullopt;
      const auto x = Entry(list[i][0]).number(kRange);
      const auto y = Entry(list[i][1]).number(kRange);
      if (!x || !y) return std::nullopt;
      corners_m.emplace_back(*x, *y);
    }
  } catch (const XmlRpc::XmlRpcException&) {  // of another type
    return std::nullopt;
  }
  return corners_m;
}

}  // namespace

navigate::Footprint FootprintParams::outline() const {
  if (corners_m.empty()) return navigate::Footprint::circle(radius_m);
  return *navigate::Footprint::make(corners_m);
}

void read_footprint(ParamReader& reader, const ros::NodeHandle& handle, FootprintParams& params) {
  reader.read("robot_radius", params.radius_m, {0.01, 9.0});
  reader.read("footprint_padding", params.padding_m, {0.0, 1.0});
  reader.accept("footprint");
  XmlRpc::XmlRpcValue given;
  if (!handle.getParam("footprint", given)) return;
  const bool is_text = given.getType() == XmlRpc::XmlRpcValue::TypeString;
  const auto corners_m = is_text ? corners_of_text(static_cast<std::string>(given)) : corners_of_list(given);
  if (!corners_m) return reader.complain("footprint must be a list of corners [[x, y], ...] in m");
  params.corners_m = *corners_m;
  if (params.corners_m.empty()) return;
  if (const auto made = navigate::Footprint::make(params.corners_m); !made)
    reader.complain(made.error().message);
}

}  // namespace extperfc::ros_params
