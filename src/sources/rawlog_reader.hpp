#pragma once

#include <deque>
#include <filesystem>

#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/serialization/CArchive.h>

namespace extperfc::sources {

/// Reads the RGB-D observations of a rawlog, plain or gzip, one after the other. Log entries have no length
/// on file, so skipping means reading; one entry at a time is held in memory.
class RawlogReader {
 public:
  using Scan = mrpt::obs::CObservation3DRangeScan::Ptr;

  explicit RawlogReader(const std::filesystem::path& file);

  [[nodiscard]] bool is_open() const { return stream_.fileOpenCorrectly(); }
  /// The next observation, null at the end. Throws std::exception when the file is damaged or breaks off.
  [[nodiscard]] Scan next();

 private:
  void keep_scans(const mrpt::serialization::CSerializable::Ptr& entry);

  mrpt::io::CFileGZInputStream stream_;
  mrpt::serialization::CArchiveStreamBase<mrpt::io::CFileGZInputStream> archive_{stream_};
  std::deque<Scan> waiting_;  // of the last entry: a sensory frame may hold several
};

}  // namespace extperfc::sources
