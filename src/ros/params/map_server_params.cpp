#include "ros/params/map_server_params.hpp"

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

Result<MapServerParams> load_map_server_params(const ros::NodeHandle& private_handle,
                                               const std::string& map_file) {
  MapServerParams params;
  ParamReader reader(private_handle);
  reader.read("map_file", params.map_file);
  reader.read("floors", params.floors);
  reader.read("floor", params.floor);
  reader.read("frame_id", params.frame_id);
  if (!map_file.empty()) params.map_file = map_file;
  if (params.map_file.empty() == params.floors.empty())
    reader.complain(private_handle.getNamespace() +
                    ": give map_file, the YAML file of a map, or floors, that of named floors");
  if (!params.floor.empty() && params.floors.empty())
    reader.complain(private_handle.resolveName("floor") + " needs floors, the YAML file of named floors");
  if (params.frame_id.empty()) reader.complain(private_handle.resolveName("frame_id") + " must not be empty");
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

}  // namespace extperfc::ros_params
