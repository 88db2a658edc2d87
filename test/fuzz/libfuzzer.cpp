// The entry points that libFuzzer looks for.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "test/fuzz/target.hpp"

/// Writes the seeds into the folder that the variable EXTPERFC_FUZZ_SEEDS names, and ends.
extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  const char* folder = std::getenv("EXTPERFC_FUZZ_SEEDS");
  if (folder == nullptr) return 0;
  std::size_t number = 0;
  for (const auto& seed : extperfc::fuzz::seeds())
    std::ofstream(std::filesystem::path(folder) / ("seed_" + std::to_string(number++)), std::ios::binary)
        << seed;
  std::exit(0);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  extperfc::fuzz::run({reinterpret_cast<const char*>(data), size});
  return 0;
}
