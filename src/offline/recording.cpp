#include "extperfc/offline/recording.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <system_error>

#include "extperfc/base/late_library.hpp"
#include "extperfc/base/text.hpp"

namespace extperfc::offline {

namespace {

namespace fs = std::filesystem;
using OpenedLog = Result<std::unique_ptr<sources::ScanLog>>;

OpenedLog open_bag(const fs::path& file, const RecordingOptions& options) {
  static const char kHere = 0;
  const auto entry = late_symbol("extperfc_scan_bag", "extperfc_open_scan_bag", &kHere);
  if (!entry)
    return fail(ErrorCode::kUnsupported, "cannot read the bag " + file.string() + ": " +
                                             entry.error().message + "; build the package with ROS");
  OpenedLog opened = fail(ErrorCode::kFailed, "");
  reinterpret_cast<decltype(&extperfc_open_scan_bag)> (*entry)(file, options, opened);
  return opened;
}

bool is_text(const std::string& start) {
  return std::none_of(start.begin(), start.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return (byte < ' ' && std::isspace(byte) == 0) || byte == 127;
  });
}

/// MRPT's objects begin with the length of the class's name, its highest bit set, and the name.
bool is_mrpt(const std::string& start) {
  return start.size() > 2 && (static_cast<unsigned char>(start[0]) & 0x80U) != 0 &&
         (start[1] == 'C' || start.compare(1, 6, "mrpt::") == 0);
}

}  // namespace

OpenedLog open_recording(const fs::path& file, const RecordingOptions& options) {
  std::error_code error;
  if (fs::is_directory(file, error))
    return fail(ErrorCode::kInvalidArgument, file.string() + " is a folder; give one recording");
  std::ifstream in(file, std::ios::binary);
  if (!in) return fail(ErrorCode::kNotFound, "cannot read " + file.string());
  std::string start(512, '\0');
  in.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(in.gcount()));
  if (start.empty()) return fail(ErrorCode::kCorrupt, file.string() + " is empty");
  if (start.compare(0, 8, "#ROSBAG ") == 0) return open_bag(file, options);
  if (is_mrpt(start) || ends_with(file.string(), ".rawlog"))
    return sources::open_scan_rawlog(file, options.log);
  const bool packed = start.compare(0, 2, "\x1f\x8b") == 0 || start.compare(0, 3, "BZh") == 0;
  if (packed || is_text(start)) return sources::open_carmen_log(file, options.log);
  return fail(ErrorCode::kUnsupported,
              file.string() +
                  " is neither a CARMEN log (text, plain, .gz or .bz2) nor a ROS bag "
                  "nor an MRPT rawlog (name it .rawlog if it is packed)");
}

}  // namespace extperfc::offline
