#include "extperfc/base/atomic_file.hpp"

#include <cerrno>
#include <fstream>
#include <locale>
#include <string>
#include <system_error>

#include <unistd.h>

namespace extperfc {

namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> cannot_write(const fs::path& file, int reason) {
  return fail(ErrorCode::kFailed, "cannot write " + file.string() + ": " +
                                      std::generic_category().message(reason == 0 ? EIO : reason));
}

}  // namespace

Result<void> write_file_atomically(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  const fs::path part = file.string() + "." + std::to_string(getpid()) + ".part";
  errno = 0;
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  if (!out) return cannot_write(file, errno);
  out.imbue(std::locale::classic());
  write(out);
  out.close();
  const int reason = errno;
  std::error_code error;
  if (!out) {
    fs::remove(part, error);
    return cannot_write(file, reason);
  }
  fs::rename(part, file, error);
  if (!error) return {};
  const int rename_reason = error.value();
  fs::remove(part, error);
  return cannot_write(file, rename_reason);
}

Result<void> write_text_atomically(const fs::path& file, const std::string& text) {
  std::error_code error;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), error);
  if (error) return cannot_write(file, error.value());
  return write_file_atomically(file, [&](std::ostream& out) { out << text; });
}

}  // namespace extperfc
