#include "sources/rawlog_reader.hpp"

#include <utility>

#include <mrpt/obs/CSensoryFrame.h>

namespace extperfc::sources {

using mrpt::obs::CObservation3DRangeScan;

RawlogReader::RawlogReader(const std::filesystem::path& file) {
  stream_.open(file.string());
}

RawlogReader::Scan RawlogReader::next() {
  while (waiting_.empty()) {
    try {
      keep_scans(archive_.ReadObject());
    } catch (const mrpt::serialization::CExceptionEOF&) {  // thrown between two entries only: the regular end
      return nullptr;
    }
  }
  Scan scan = std::move(waiting_.front());
  waiting_.pop_front();
  return scan;
}

void RawlogReader::keep_scans(const mrpt::serialization::CSerializable::Ptr& entry) {
  if (auto scan = std::dynamic_pointer_cast<CObservation3DRangeScan>(entry))
    waiting_.push_back(std::move(scan));
  const auto moment = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(entry);
  if (!moment) return;
  for (const auto& observation : *moment)
    if (auto scan = std::dynamic_pointer_cast<CObservation3DRangeScan>(observation))
      waiting_.push_back(std::move(scan));
}

}  // namespace extperfc::sources
