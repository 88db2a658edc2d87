#include "test/benchmark/translate/stage.hpp"

#include <array>
#include <cstdlib>
#include <system_error>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "extperfc/base/stopwatch.hpp"

namespace extperfc::benchmark {

namespace {

constexpr double kMasterPatienceS = 30.0;

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// An unused port; 0 if there is none.
std::uint16_t free_port() {
  const int probe = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  auto address = loopback(0);
  socklen_t size = sizeof address;
  const bool bound =
      bind(probe, reinterpret_cast<sockaddr*>(&address), size) == 0 &&        // NOLINT: the interface's way
      getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size) == 0;  // NOLINT
  close(probe);
  return bound ? ntohs(address.sin_port) : 0;
}

bool listens(std::uint16_t port) {
  const int probe = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const auto address = loopback(port);
  const bool connected =
      connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;  // NOLINT
  close(probe);
  return connected;
}

/// Hundreds of topics need more than the 1024 descriptors that a shell allows.
void allow_many_descriptors() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

void set_environment(const std::filesystem::path& folder) {
  setenv("ROS_IP", "127.0.0.1", 1);
  setenv("ROS_HOME", folder.c_str(), 1);
  setenv("ROS_LOG_DIR", (folder / "log").c_str(), 1);
  for (const char* name : {"ROS_HOSTNAME", "ROS_NAMESPACE"}) unsetenv(name);
}

}  // namespace

Result<Stage> Stage::make() {
  std::string pattern = (std::filesystem::temp_directory_path() / "bench_translate_XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr)
    return fail(ErrorCode::kFailed, "cannot make a folder like " + pattern);
  Stage stage;
  stage.folder_ = pattern;
  allow_many_descriptors();
  set_environment(stage.folder_);
  auto definitions = make_definitions();
  if (!definitions) return tl::unexpected(definitions.error());
  stage.definitions_ = std::move(*definitions);
  if (auto written = write_packages(stage.folder_); !written) return tl::unexpected(written.error());
  for (int i = 0; i < 2; ++i)
    if (auto started = stage.start_master(); !started) return tl::unexpected(started.error());
  return stage;
}

Stage::~Stage() {
  masters_.clear();
  std::error_code ignored;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
}

Result<void> Stage::start_master() {
  const auto port = free_port();
  const auto log = (folder_ / ("master_" + std::to_string(port) + ".log")).string();
  auto master = Process::start_program({"rosmaster", "--core", "-p", std::to_string(port)}, log);
  if (!master) return tl::unexpected(master.error());
  const Stopwatch watch;
  while (!listens(port)) {
    if (!master->alive() || watch.seconds() > kMasterPatienceS)
      return fail(ErrorCode::kFailed, "rosmaster does not start; is it installed, and on the PATH?");
    usleep(20'000);
  }
  masters_.push_back(std::move(*master));
  uris_.push_back("http://127.0.0.1:" + std::to_string(port));
  return {};
}

}  // namespace extperfc::benchmark
