#include "test/unit/scan/real_revolution.hpp"

namespace extperfc::scan {

RealRevolution read_real_revolution(std::string& why) {
  why = "built without MRPT (libmrpt-obs-dev)";
  return {};
}

}  // namespace extperfc::scan
