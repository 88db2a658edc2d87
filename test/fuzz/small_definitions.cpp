#include "test/fuzz/small_definitions.hpp"

#include "test/fuzz/target.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::fuzz {

namespace {

void write_common(const TemporaryFolder& folder, const std::string& set) {
  folder.write(set + "/geometry_msgs/msg/Point.msg", "float64 x\nfloat64 y\nfloat64 z\n");
  folder.write(set + "/geometry_msgs/msg/Quaternion.msg", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n");
  folder.write(set + "/geometry_msgs/msg/Pose.msg", "Point position\nQuaternion orientation\n");
}

translate::DefinitionStore make() {
  const TemporaryFolder folder;
  for (const std::string set : {"old", "middle", "new"}) write_common(folder, set);
  folder.write(
      "old/p/msg/Head.msg",
      "uint8 SLOW=1\nuint8 FAST=2\nfloat32 target\nint32 speed\nstring[] names\ngeometry_msgs/Pose[] poses\n"
      "geometry_msgs/Pose base\nbool[3] flags\nuint8 mode\n");
  folder.write(
      "new/p/msg/Head.msg",
      "uint8 WALK=10\nuint8 RUN=20\nfloat32 target\nfloat32 ratio\nstring name\ngeometry_msgs/Pose[] poses\n"
      "bool[] flags\ngeometry_msgs/Pose stand\nuint8 mode\nint8 small\ntime stamp\n");
  folder.write("old/p/msg/Chain.msg", "int32 a\n");
  folder.write("middle/p/msg/Chain.msg", "int64 b\n");
  folder.write("new/p/msg/Chain.msg", "float64 c\n");
  folder.write("old/p/srv/Ask.srv", "int32 a\n---\nbool ok\n");
  folder.write("new/p/srv/Ask.srv", "int32 a\nint32 b\n---\nbool ok\nstring why\n");
  translate::DefinitionStore store;
  for (const std::string set : {"old", "middle", "new"}) {
    const auto report = store.add_tree(folder.path() / set, set);
    require(report && report->problems.empty(), "the fuzzers' definitions are read");
  }
  return store;
}

}  // namespace

const translate::DefinitionStore& small_definitions() {
  static const translate::DefinitionStore kStore = make();
  return kStore;
}

std::string md5_of(const std::string& set, const std::string& type) {
  if (const auto message = small_definitions().message_of_set(set, type)) return message->md5();
  const auto service = small_definitions().service_of_set(set, type);
  require(service != nullptr, "the set has the type");
  return service->md5;
}

}  // namespace extperfc::fuzz
