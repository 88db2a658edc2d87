#include "extperfc/base/late_library.hpp"

#include <filesystem>

#include <dlfcn.h>

namespace extperfc {

namespace {

std::string last_reason() {
  const char* reason = dlerror();  // NOLINT(concurrency-mt-unsafe): glibc keeps one per thread
  return reason == nullptr ? "no reason given" : reason;
}

/// Loads the library from the asking library's folder, else by the system's search path. Null: see dlerror().
void* load(const std::string& file, const void* neighbour) {
  Dl_info info{};
  if (neighbour != nullptr && dladdr(neighbour, &info) != 0 && info.dli_fname != nullptr) {
    const auto beside = std::filesystem::path(info.dli_fname).parent_path() / file;
    std::error_code error;
    if (std::filesystem::exists(beside, error)) return dlopen(beside.c_str(), RTLD_NOW | RTLD_LOCAL);
  }
  return dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
}

}  // namespace

Result<void*> late_symbol(const std::string& library, const std::string& symbol, const void* neighbour) {
  const std::string file = "lib" + library + ".so";
  void* loaded = load(file, neighbour);
  if (loaded == nullptr)
    return fail(ErrorCode::kUnsupported,
                "this build or installation lacks " + file + " (" + last_reason() + ")");
  void* address = dlsym(loaded, symbol.c_str());
  if (address == nullptr)
    return fail(ErrorCode::kUnsupported, file + " is of another version (" + last_reason() + ")");
  return address;
}

}  // namespace extperfc
