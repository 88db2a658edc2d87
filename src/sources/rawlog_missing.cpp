#include "extperfc/sources/recording.hpp"

namespace extperfc::sources {

Result<std::unique_ptr<Recording>> open_rawlog(const std::filesystem::path& file) {
  return fail(
      ErrorCode::kUnsupported,
      "cannot read " + file.string() + ": this build has no MRPT; install libmrpt-obs-dev and build again");
}

}  // namespace extperfc::sources
